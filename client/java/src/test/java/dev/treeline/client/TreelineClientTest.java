package dev.treeline.client;

import static org.junit.Assert.assertArrayEquals;
import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertFalse;
import static org.junit.Assert.assertNull;
import static org.junit.Assert.assertThrows;
import static org.junit.Assert.assertTrue;

import dev.treeline.camera.Camera;
import dev.treeline.camera.Depth;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;
import dev.treeline.proto.GetSceneMapResponse;
import dev.treeline.proto.ListScenesResponse;
import dev.treeline.proto.LocalizeRequest;
import dev.treeline.proto.SceneInfo;
import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;
import java.util.Collections;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.TimeUnit;
import org.junit.Test;

public class TreelineClientTest {
  private static final String BUSY = "{\"code\":\"unavailable\","
      + "\"message\":\"the queue is full\",\"details\":["
      + "{\"type\":\"google.rpc.ErrorInfo\",\"value\":\"CgpRVUVVRQ\","
      + "\"debug\":{\"reason\":\"QUEUE_FULL\",\"domain\":\"treeline\","
      + "\"metadata\":{\"waiting\":\"9\"}}},"
      + "{\"type\":\"google.rpc.RetryInfo\",\"value\":\"CgA\","
      + "\"debug\":{\"retryDelay\":\"0.250s\"}}]}";

  private static LocalizeAnswer ask(PlayedServer server) throws Exception {
    try (TreelineClient client = TreelineClient.of(server.url()).build()) {
      return client.localize(Played.QUERY);
    }
  }

  private static TreelineException failure(PlayedServer.Play play)
      throws Exception {
    try (PlayedServer server = new PlayedServer(play)) {
      TreelineClient client = TreelineClient.of(server.url())
          .retry(RetryPolicy.NEVER).timeoutMs(60_000).build();
      return assertThrows(
          TreelineException.class, () -> client.localize(Played.QUERY));
    }
  }

  @Test
  public void theAnswerIsTheServersWord() throws Exception {
    try (PlayedServer server = new PlayedServer((request, out) ->
        PlayedServer.message(out, Played.bytes(Played.localized())))) {
      LocalizeAnswer answer = ask(server);
      assertTrue(answer.localized);
      assertEquals(new Vector3(1, 2, 3), answer.worldFromCamera.translationM);
      assertEquals(36, answer.covariance().length);
      assertEquals(LocalizeAnswer.PoseSensor.COLOR, answer.poseSensor);
      assertEquals("", answer.reason);
      assertEquals(90, answer.inliers);
      assertEquals(1, answer.focalScale, 0);
      assertEquals(1, answer.depthScale, 0);
      assertEquals(0.99, answer.fix(7).confidence, 0);
      assertEquals(7, answer.fix(7).captureTimeNs);
      PlayedServer.Request request = server.requests.get(0);
      assertEquals(
          "POST /treeline.v1.RelocalizationService/Localize HTTP/1.1",
          request.line);
      assertEquals("application/proto", request.headers.get("content-type"));
      assertEquals("1", request.headers.get("connect-protocol-version"));
      long toldMs =
          Long.parseLong(request.headers.get("connect-timeout-ms"));
      assertTrue(toldMs + " ms", toldMs > 5000 && toldMs <= 10_000);
      assertNull(request.headers.get("authorization"));
      assertNull(request.headers.get("x-treeline-scene"));
      assertNull(request.headers.get("traceparent"));
    }
  }

  @Test
  public void notLocalizedIsAnAnswer() throws Exception {
    try (PlayedServer server = new PlayedServer((request, out) ->
        PlayedServer.message(out, Played.bytes(
            Played.notLocalized().setFocalScale(1.2)
                .setCamera(dev.treeline.proto.Camera.newBuilder()
                    .setModel("SIMPLE_PINHOLE").setWidthPx(40).setHeightPx(30)
                    .addParameters(31).addParameters(19.5)
                    .addParameters(14.5)))))) {
      LocalizeAnswer answer = ask(server);
      assertFalse(answer.localized);
      assertNull(answer.worldFromCamera);
      assertNull(answer.fix(7));
      assertEquals("TOO_FEW_INLIERS", answer.reason);
      assertEquals(1.2, answer.focalScale, 0);
      assertEquals("SIMPLE_PINHOLE", answer.camera.model);
      assertEquals(40, answer.camera.widthPx);
    }
    try (PlayedServer server = new PlayedServer((request, out) ->
        PlayedServer.message(out, Played.bytes(
            Played.notLocalized().setReasonValue(99))))) {
      assertEquals("REASON_99", ask(server).reason);
    }
  }

  @Test
  public void everythingThatIsAskedReachesTheServer() throws Exception {
    Camera camera = Camera.pinhole(640, 480, 500, 501, 319.5, 239.5);
    LocalizeQuery query = LocalizeQuery.of(new byte[] {9, 8})
        .scene("kitchen").modelVersion("3").camera(camera)
        .depth(Depth.ofValues(new short[] {1, 2}, 2, 1, 0.001)
            .ofCamera(camera, RigidTransform.IDENTITY).scaled(1.1))
        .sideUpGuess(SideUp.ofExif(6))
        .gravityInCameraMps2(new Vector3(0, 9.81, 0)).seed(-1)
        .timeBudgetMs(70).minConfidence(0.4)
        .prior(new LocalizeQuery.PosePrior(RigidTransform.IDENTITY, 2, 0.5))
        .positionPrior(
            new LocalizeQuery.PositionPrior(new Vector3(1, 2, 3), 4))
        .heightBand(new LocalizeQuery.HeightBand(
            new Vector3(0, 1, 0), 1, 2)).wantsCorrespondences(true).build();
    try (PlayedServer server = new PlayedServer((request, out) ->
            PlayedServer.message(out, Played.bytes(Played.localized())));
        TreelineClient client = TreelineClient.of(server.url() + "/")
            .token("secret").sceneHeader(true)
            .traceparent(() -> Traceparent.create(true)).build()) {
      client.localize(query, 2000);
      PlayedServer.Request sent = server.requests.get(0);
      assertEquals("Bearer secret", sent.headers.get("authorization"));
      assertEquals("kitchen", sent.headers.get("x-treeline-scene"));
      assertTrue(Traceparent.isOne(sent.headers.get("traceparent")));
      LocalizeRequest told = LocalizeRequest.parseFrom(sent.body);
      assertEquals("kitchen", told.getScene());
      assertEquals("3", told.getModelVersion());
      assertArrayEquals(new byte[] {9, 8},
          told.getFrame().getColor().getEncoded().toByteArray());
      assertEquals(501, told.getFrame().getCamera().getParameters(1), 0);
      assertEquals("DEPTH_REGISTRATION_EXPLICIT",
          told.getFrame().getDepth().getRegistration().name());
      assertEquals(1.1, told.getFrame().getDepth().getDepthScale(), 0);
      assertArrayEquals(new byte[] {1, 0, 2, 0},
          told.getFrame().getDepth().getRaw().getData().toByteArray());
      assertEquals(640, told.getFrame().getDepth().getCalibration()
          .getDepthCamera().getWidthPx());
      assertEquals("ORIENTATION_LEFT_UP",
          told.getFrame().getOrientation().name());
      assertTrue(told.getFrame().getOrientationIsGuess());
      assertEquals(
          9.81, told.getFrame().getGravityInCameraMps2().getY(), 0);
      assertEquals(-1, told.getOptions().getSeed());
      assertEquals(70, told.getOptions().getTimeBudgetMs(), 0);
      assertEquals(0.4, told.getOptions().getMinConfidence(), 0);
      assertEquals(
          2, told.getOptions().getPrior().getPositionRadiusM(), 0);
      assertTrue(
          told.getOptions().getPrior().getWorldFromCamera().hasRotation());
      assertEquals(3, told.getOptions().getPositionPrior()
          .getPositionInWorldM().getZ(), 0);
      assertEquals(
          1, told.getOptions().getHeightBand().getUpInWorld().getY(), 0);
      assertTrue(told.getOptions().getIncludeCorrespondences());
    }
  }

  @Test
  public void pixelsAndPngDepthAreTaken() throws Exception {
    LocalizeQuery query = LocalizeQuery
        .of(new RgbImage(1, 1, new byte[] {1, 2, 3}))
        .candidateScenes(Arrays.asList("a", "b"))
        .depth(Depth.ofPng(new byte[] {7}, 0.001).ofSceneCamera()).build();
    try (PlayedServer server = new PlayedServer((request, out) ->
            PlayedServer.message(out, Played.bytes(Played.localized())));
        TreelineClient client = TreelineClient.of(server.url())
            .sceneHeader(true).build()) {
      client.localize(query);
      // There is no scene to name.
      assertNull(server.requests.get(0).headers.get("x-treeline-scene"));
      LocalizeRequest told =
          LocalizeRequest.parseFrom(server.requests.get(0).body);
      assertEquals(Arrays.asList("a", "b"), told.getCandidateScenesList());
      assertEquals(3, told.getFrame().getColor().getRgb8().getData().size());
      assertEquals(1, told.getFrame().getDepth().getPng().size());
      assertFalse(told.getFrame().getDepth().hasDepthScale());
    }
    assertThrows(IllegalArgumentException.class,
        () -> new RgbImage(2, 2, new byte[3]));
    assertThrows(NullPointerException.class,
        () -> LocalizeQuery.of((byte[]) null));
  }

  @Test
  public void errorsSayWhy() throws Exception {
    TreelineException error = failure((request, out) ->
        PlayedServer.error(out, 503, "Retry-After: 1\r\n", BUSY));
    assertEquals(ErrorCode.UNAVAILABLE, error.code);
    assertEquals("the queue is full", error.getMessage());
    assertEquals("QUEUE_FULL", error.reason);
    assertEquals(Collections.singletonMap("waiting", "9"), error.metadata());
    // The exact time, not that of the header.
    assertEquals(250, error.retryAfterMs);
    TreelineException token = failure((request, out) ->
        PlayedServer.error(out, 401, "WWW-Authenticate: Bearer\r\n",
            "{\"code\":\"unauthenticated\",\"message\":\"none\",\"details\":[{"
                + "\"type\":\"google.rpc.ErrorInfo\",\"debug\":"
                + "{\"reason\":\"TOKEN_MISSING\"}}]}"));
    assertEquals(ErrorCode.UNAUTHENTICATED, token.code);
    assertEquals("TOKEN_MISSING", token.reason);
    assertEquals(-1, token.retryAfterMs);
  }

  @Test
  public void aProxysErrorIsOneToo() throws Exception {
    TreelineException error = failure((request, out) ->
        PlayedServer.send(out, 502, "Content-Type: text/html\r\n",
            "<html>".getBytes(StandardCharsets.US_ASCII)));
    assertEquals(ErrorCode.UNAVAILABLE, error.code);
    assertEquals(ErrorCode.UNIMPLEMENTED, failure((request, out) ->
        PlayedServer.send(out, 404, "", new byte[0])).code);
    assertEquals(ErrorCode.UNKNOWN, failure((request, out) ->
        PlayedServer.error(out, 500, "", "{\"code\":\"surprise\"}")).code);
    assertEquals(ErrorCode.UNKNOWN, failure((request, out) ->
        PlayedServer.error(out, 500, "", "[{]")).code);
  }

  @Test
  public void liesAreNoAnswers() throws Exception {
    // A hotel's page, with status 200.
    TreelineException portal = failure((request, out) ->
        PlayedServer.send(out, 200, "Content-Type: text/html\r\n",
            "<html>Welcome".getBytes(StandardCharsets.US_ASCII)));
    assertEquals(ErrorCode.UNKNOWN, portal.code);
    assertTrue(portal.getMessage(), portal.getMessage().contains("portal"));
    // One that redirects there: nothing is sent on.
    assertEquals(ErrorCode.UNKNOWN, failure((request, out) ->
        PlayedServer.send(out, 302, "Location: http://127.0.0.1:1/\r\n",
            new byte[0])).code);
    assertEquals(ErrorCode.INTERNAL, failure((request, out) ->
        PlayedServer.message(out, new byte[] {-1, -1, -1})).code);
    // Empty: no outcome.
    assertEquals(ErrorCode.INTERNAL, failure((request, out) ->
        PlayedServer.message(out, new byte[0])).code);
    assertEquals(ErrorCode.INTERNAL, failure((request, out) ->
        PlayedServer.message(out, Played.bytes(
            Played.localized().addCovariance(1)))).code);
    assertEquals(ErrorCode.INTERNAL, failure((request, out) ->
        PlayedServer.message(out, Played.bytes(
            Played.localized().clearWorldFromCamera()))).code);
    // It ends in the middle.
    assertEquals(ErrorCode.UNAVAILABLE, failure((request, out) -> {
      out.write(("HTTP/1.1 200 OK\r\nContent-Type: application/proto\r\n"
          + "Content-Length: 100\r\n\r\nabc")
          .getBytes(StandardCharsets.US_ASCII));
      throw new IOException("gone");
    }).code);
    // It never ends.
    TreelineException endless = failure((request, out) -> {
      out.write(("HTTP/1.1 200 OK\r\nContent-Type: application/proto\r\n"
          + "\r\n").getBytes(StandardCharsets.US_ASCII));
      byte[] more = new byte[1 << 20];
      for (;;) out.write(more);
    });
    assertEquals(ErrorCode.INTERNAL, endless.code);
    assertTrue(endless.getMessage(),
        endless.getMessage().contains("larger than"));
  }

  @Test
  public void aServerThatStallsIsLeftInTime() throws Exception {
    try (PlayedServer server = new PlayedServer((request, out) -> {
      throw new PlayedServer.Stall();
    }); TreelineClient client = TreelineClient.of(server.url()).build()) {
      long startNs = System.nanoTime();
      TreelineException error = assertThrows(TreelineException.class,
          () -> client.localize(Played.QUERY, 200));
      assertEquals(ErrorCode.DEADLINE_EXCEEDED, error.code);
      assertTrue(System.nanoTime() - startNs < TimeUnit.SECONDS.toNanos(30));
      assertTrue("the connection is closed", server.hasBeenLeft());
    }
  }

  @Test
  public void aServerThatTricklesIsLeftInTime() throws Exception {
    try (PlayedServer server = new PlayedServer((request, out) -> {
      out.write("HTTP/1.1 200 OK\r\nX-Long: ".getBytes(
          StandardCharsets.US_ASCII));
      for (;;) {
        out.write('a');
        out.flush();
        Thread.sleep(20);
      }
    }); TreelineClient client = TreelineClient.of(server.url()).build()) {
      TreelineException error = assertThrows(TreelineException.class,
          () -> client.localize(Played.QUERY, 300));
      assertEquals(ErrorCode.DEADLINE_EXCEEDED, error.code);
      assertTrue("the connection is closed", server.hasBeenLeft());
    }
  }

  @Test
  public void aCancelledFutureFreesTheServer() throws Exception {
    try (PlayedServer server = new PlayedServer((request, out) -> {
      throw new PlayedServer.Stall();
    }); TreelineClient client = TreelineClient.of(server.url()).build()) {
      CompletableFuture<LocalizeAnswer> future =
          client.localizeAsync(Played.QUERY);
      while (server.requests.isEmpty()) Thread.sleep(1);
      assertTrue(future.cancel(true));
      assertTrue("the connection is closed", server.hasBeenLeft());
      assertEquals(1, server.requests.size());
    }
  }

  @Test
  public void aClosedClientCancelsAll() throws Exception {
    try (PlayedServer server = new PlayedServer((request, out) -> {
      throw new PlayedServer.Stall();
    })) {
      TreelineClient client = TreelineClient.of(server.url()).build();
      CompletableFuture<LocalizeAnswer> future =
          client.localizeAsync(Played.QUERY);
      while (server.requests.isEmpty()) Thread.sleep(1);
      client.close();
      assertEquals(ErrorCode.CANCELED, codeOf(future));
      assertTrue("the connection is closed", server.hasBeenLeft());
      assertEquals(
          ErrorCode.CANCELED, codeOf(client.localizeAsync(Played.QUERY)));
      assertEquals(1, server.requests.size());
    }
  }

  private static ErrorCode codeOf(CompletableFuture<?> future) {
    ExecutionException error = assertThrows(ExecutionException.class,
        () -> future.get(60, TimeUnit.SECONDS));
    return ((TreelineException) error.getCause()).code;
  }

  @Test
  public void anInterruptedThreadWaitsNoLonger() throws Exception {
    try (PlayedServer server = new PlayedServer((request, out) -> {
      throw new PlayedServer.Stall();
    }); TreelineClient client = TreelineClient.of(server.url()).build()) {
      Thread.currentThread().interrupt();
      TreelineException error = assertThrows(
          TreelineException.class, () -> client.localize(Played.QUERY));
      assertEquals(ErrorCode.CANCELED, error.code);
      assertTrue("it is still interrupted", Thread.interrupted());
    }
  }

  @Test
  public void theMainThreadIsNotBlocked() throws Exception {
    try (PlayedServer server = new PlayedServer((request, out) ->
            PlayedServer.message(out, Played.bytes(Played.localized())));
        TreelineClient client = TreelineClient.of(server.url()).build()) {
      android.os.Looper.IS_MAIN.set(true);
      try {
        assertThrows(
            IllegalStateException.class, () -> client.localize(Played.QUERY));
        assertThrows(IllegalStateException.class, client::listScenes);
        assertTrue(client.localizeAsync(Played.QUERY)
            .get(60, TimeUnit.SECONDS).localized);
      } finally {
        android.os.Looper.IS_MAIN.set(false);
      }
    }
  }

  @Test
  public void connectionsAreKept() throws Exception {
    try (PlayedServer server = new PlayedServer((request, out) -> {
      if (request.body.length > 100) {
        PlayedServer.error(out, 400, "", "{\"code\":\"invalid_argument\"}");
      } else {
        PlayedServer.message(out, Played.bytes(Played.localized()));
      }
    }); TreelineClient client = TreelineClient.of(server.url()).build()) {
      for (int i = 0; i < 5; ++i) {
        client.localize(Played.QUERY);
        assertThrows(TreelineException.class, () -> client.localize(
            LocalizeQuery.of(new byte[200]).build()));
      }
      assertEquals(10, server.requests.size());
      assertEquals(1, server.connections());
    }
  }

  @Test
  public void noNetworkIsUnavailable() throws Exception {
    PlayedServer gone = new PlayedServer((request, out) -> {});
    gone.close();
    Played.PlayedTools tools = new Played.PlayedTools();
    TreelineClient client =
        TreelineClient.of(gone.url()).tools(tools).build();
    TreelineException error = assertThrows(
        TreelineException.class, () -> client.localize(Played.QUERY));
    assertEquals(ErrorCode.UNAVAILABLE, error.code);
    assertTrue(error.getMessage(),
        error.getMessage().startsWith(gone.url() + " cannot be reached: "));
    // Half of 50, 150 and 450 ms: chance is 0.
    assertEquals(Arrays.asList(25L, 75L, 225L), tools.sleptMs);
    ServerHealth health = client.health().get(0);
    assertFalse(health.reachable);
    assertFalse(health.ready);
  }

  @Test
  public void tokensAreAskedForAndNeverTold() throws Exception {
    try (PlayedServer server = new PlayedServer((request, out) ->
        PlayedServer.message(out, Played.bytes(Played.localized())))) {
      TreelineException none = assertThrows(TreelineException.class, () ->
          TreelineClient.of(server.url()).tokenSupplier(() -> {
            throw new IOException("the keystore is locked");
          }).build().localize(Played.QUERY));
      assertEquals(ErrorCode.UNAUTHENTICATED, none.code);
      assertEquals("the keystore is locked", none.getCause().getMessage());
      TreelineException line = assertThrows(TreelineException.class, () ->
          TreelineClient.of(server.url()).token("secret\n").build()
              .localize(Played.QUERY));
      assertEquals(ErrorCode.UNAUTHENTICATED, line.code);
      assertFalse(line.getMessage().contains("secret"));
      assertTrue(server.requests.isEmpty());
    }
  }

  @Test
  public void whatIsNoServerIsRefused() {
    for (String bad : new String[] {"kitchen", "ftp://a.example", "http://",
        "https://a.example/?x=1", "https://me@a.example", "http://a b"}) {
      assertThrows(bad, IllegalArgumentException.class,
          () -> TreelineClient.of(bad).build());
    }
    assertThrows(IllegalArgumentException.class,
        () -> TreelineClient.of().build());
  }

  @Test
  public void anotherTransportIsTaken() throws Exception {
    HttpTransport.HttpCall call = new HttpTransport.HttpCall() {
      @Override
      public HttpResponse execute() {
        return new HttpResponse(200, Collections.singletonMap(
            "content-type", "application/proto"),
            Played.bytes(Played.localized()));
      }

      @Override
      public void cancel() {}
    };
    TreelineClient client = TreelineClient.of("https://a.example/treeline/")
        .transport(request -> {
          assertEquals("https://a.example/treeline/treeline.v1."
              + "RelocalizationService/Localize", request.url);
          return call;
        }).build();
    assertTrue(client.localize(Played.QUERY).localized);
    // A fault of its own is told, whatever it is.
    TreelineException fault = assertThrows(TreelineException.class, () ->
        TreelineClient.of("https://a.example").transport(request ->
            new HttpTransport.HttpCall() {
              @Override
              public HttpResponse execute() {
                throw new SecurityException("missing INTERNET permission?");
              }

              @Override
              public void cancel() {}
            }).build().localize(Played.QUERY));
    assertEquals(ErrorCode.INTERNAL, fault.code);
    assertTrue(fault.getMessage().contains("INTERNET"));
  }

  @Test
  public void scenesAndMapsAreRead() throws Exception {
    ListScenesResponse scenes = ListScenesResponse.newBuilder()
        .addScenes(SceneInfo.newBuilder().setScene("attic").setState(
            dev.treeline.proto.SceneState.SCENE_STATE_UNLOADED)).build();
    try (PlayedServer server = new PlayedServer((request, out) -> {
      if (request.line.contains("ListScenes")) {
        PlayedServer.message(out, scenes.toByteArray());
      } else {
        // Points without brightness.
        PlayedServer.message(out, GetSceneMapResponse.newBuilder()
            .setPointsInWorldM(com.google.protobuf.ByteString.copyFrom(
                new byte[12])).build().toByteArray());
      }
    }); TreelineClient client = TreelineClient.of(server.url()).build()) {
      Scene attic = client.listScenesAsync().get(60, TimeUnit.SECONDS).get(0);
      assertEquals("attic", attic.name);
      assertEquals(SceneState.UNLOADED, attic.state);
      assertNull(attic.camera);
      assertNull(attic.method);
      assertNull(attic.geoAnchor);
      assertEquals(ErrorCode.INTERNAL, assertThrows(TreelineException.class,
          () -> client.getSceneMap("attic", 0, false)).code);
    }
  }
}
