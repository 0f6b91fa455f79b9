package dev.treeline.client;

import static org.junit.Assert.assertArrayEquals;
import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertFalse;
import static org.junit.Assert.assertNotNull;
import static org.junit.Assert.assertThrows;
import static org.junit.Assert.assertTrue;

import dev.treeline.camera.Depth;
import dev.treeline.fusion.DriftCorrector;
import dev.treeline.fusion.DriftEstimate;
import dev.treeline.fusion.DriftParameters;
import dev.treeline.fusion.DriftState;
import dev.treeline.fusion.Fix;
import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;
import java.awt.image.Raster;
import java.io.BufferedReader;
import java.io.File;
import java.io.IOException;
import java.io.InputStream;
import java.io.InputStreamReader;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.Paths;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Collections;
import java.util.List;
import java.util.Map;
import java.util.concurrent.BlockingQueue;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.TimeUnit;
import javax.imageio.ImageIO;
import org.junit.AfterClass;
import org.junit.Assume;
import org.junit.BeforeClass;
import org.junit.Test;

/**
 * The client against treeline-server with a scene that it has learned: the same
 * answers as treeline-client's. Run by ctest (java.server), with the programs
 * and the scene of tests/integration/make_scene.cmake in the environment.
 */
public class ServerCheck {
  private static final double FIVE_CM = 0.05;

  // One treeline-server, and its addresses.
  private static final class Server {
    final Process process;
    String grpc = "";
    String http = "";

    Server(String... flags) throws IOException {
      List<String> command = new ArrayList<>(Arrays.asList(
          environment("TREELINE_SERVER"), "--models",
          folder.resolve("models").toString(), "--listen", "127.0.0.1:0",
          "--admin-listen", "", "--http-listen", "127.0.0.1:0", "--drain-s",
          "0"));
      command.addAll(Arrays.asList(flags));
      process = new ProcessBuilder(command)
          .redirectError(ProcessBuilder.Redirect.INHERIT).start();
      SERVERS.add(this);
      BufferedReader lines = new BufferedReader(new InputStreamReader(
          process.getInputStream(), StandardCharsets.UTF_8));
      while (http.isEmpty()) {
        String line = lines.readLine();
        assertNotNull("the server ended", line);
        if (line.startsWith("listening on ")) grpc = line.substring(13);
        if (line.startsWith("http on ")) http = line.substring(8);
      }
    }
  }

  private static final List<Server> SERVERS = new ArrayList<>();
  private static Path folder;
  private static Path recording;
  private static List<String> stems;
  private static Server plain;

  private static String environment(String name) {
    String value = System.getenv(name);
    assertNotNull(name + " is not set", value);
    return value;
  }

  @BeforeClass
  public static void start() throws IOException {
    Path scene = Paths.get(environment("TREELINE_SCENE"));
    recording = scene.resolve("recording");
    stems = Arrays.asList(new String(Files.readAllBytes(
        recording.resolve("test.txt")), StandardCharsets.UTF_8)
        .trim().split("\\s+"));
    folder = Files.createTempDirectory("treeline-java-");
    Path version = folder.resolve("models/room/1");
    Files.createDirectories(version);
    Files.copy(
        scene.resolve("room.treeline"), version.resolve("model.treeline"));
    Files.write(folder.resolve("models/room/scene.json"),
        ("{\"display_name\":\"Room\",\"geo_anchor\":{\"latitude_deg\":48.137,"
            + "\"longitude_deg\":11.575,\"height_m\":520,"
            + "\"enu_from_world\":{\"w\":1,\"x\":0,\"y\":0,\"z\":0}}}")
            .getBytes(StandardCharsets.UTF_8));
    plain = new Server();
  }

  @AfterClass
  public static void stop() throws Exception {
    for (Server server : SERVERS) {
      server.process.destroy();
      server.process.waitFor();
    }
    List<Path> files = new ArrayList<>();
    Files.walk(folder).forEach(files::add);
    Collections.reverse(files);
    for (Path file : files) Files.delete(file);
  }

  private static Path file(String stem, String kind) {
    return recording.resolve(stem + "." + kind);
  }

  private static LocalizeQuery.Builder query(String stem) throws IOException {
    return LocalizeQuery.of(Files.readAllBytes(file(stem, "color.jpg")))
        .depth(Depth.ofPng(Files.readAllBytes(file(stem, "depth.png")), 0.001)
            .ofSceneCamera());
  }

  private static TreelineClient client() {
    return TreelineClient.of("http://" + plain.http).build();
  }

  private static String run(int allowed, String... command)
      throws Exception {
    Process process = new ProcessBuilder(command)
        .redirectError(ProcessBuilder.Redirect.INHERIT).start();
    StringBuilder text = new StringBuilder();
    try (InputStreamReader in = new InputStreamReader(
        process.getInputStream(), StandardCharsets.UTF_8)) {
      for (int sign = in.read(); sign >= 0; sign = in.read()) {
        text.append((char) sign);
      }
    }
    int status = process.waitFor();
    assertTrue(command[0] + ": " + status, status == 0 || status == allowed);
    return text.toString();
  }

  // What treeline-client says of a frame; 3: not localized.
  private static Map<String, Object> answerOfCpp(String stem)
      throws Exception {
    return JsonFile.parse(run(3, environment("TREELINE_CLIENT"), "localize",
        "--server", plain.grpc, "--scene", "room", "--color",
        file(stem, "color.jpg").toString(), "--depth",
        file(stem, "depth.png").toString(), "--json"));
  }

  // worldFromCamera of the recording; 7-Scenes has rows.
  private static RigidTransform truth(String stem) throws IOException {
    String[] rows = new String(Files.readAllBytes(file(stem, "pose.txt")),
        StandardCharsets.UTF_8).trim().split("\\s+");
    double[] columns = new double[16];
    for (int i = 0; i < 16; ++i) {
      columns[i] = Double.parseDouble(rows[(i % 4) * 4 + i / 4]);
    }
    return RigidTransform.fromColumnMajor4(columns);
  }

  private static double distance(RigidTransform a, RigidTransform b) {
    return a.translationM.minus(b.translationM).norm();
  }

  @Test
  public void answersAreThoseOfTreelineClientBitForBit() throws Exception {
    int localized = 0;
    try (TreelineClient client = client()) {
      for (String stem : stems.subList(0, 5)) {
        LocalizeAnswer ours =
            client.localize(query(stem).scene("room").build());
        Map<String, Object> theirs = answerOfCpp(stem);
        assertEquals(theirs.get("outcome").equals("LOCALIZED"),
            ours.localized);
        assertEquals((Double) theirs.get("inliers"), ours.inliers, 0);
        assertEquals((Double) theirs.get("samples"), ours.samples, 0);
        assertEquals((Double) theirs.get("confidence"), ours.confidence, 0);
        assertEquals(theirs.get("scene"), ours.scene);
        assertEquals(theirs.get("version"), ours.modelVersion);
        if (!ours.localized) {
          assertEquals(theirs.get("reason"), ours.reason);
          continue;
        }
        ++localized;
        Quaternion q = ours.worldFromCamera.rotation;
        Vector3 t = ours.worldFromCamera.translationM;
        Object pose = theirs.get("world_from_camera");
        assertArrayEquals(new double[] {q.w, q.x, q.y, q.z, t.x, t.y, t.z},
            Arrays.stream(new String[] {
                "qw", "qx", "qy", "qz", "tx", "ty", "tz"}).mapToDouble(
                    name -> (Double) Json.at(pose, name)).toArray(), 0);
        assertArrayEquals(((List<?>) theirs.get("covariance")).stream()
            .mapToDouble(one -> (Double) one).toArray(),
            ours.covariance(), 0);
        assertTrue(distance(ours.worldFromCamera, truth(stem)) < FIVE_CM);
      }
    }
    assertTrue(localized + " of 5", localized >= 3);
  }

  @Test
  public void rawDepthIsThatOfThePng() throws Exception {
    String stem = stems.get(0);
    Raster raster =
        ImageIO.read(file(stem, "depth.png").toFile()).getData();
    short[] values = new short[raster.getWidth() * raster.getHeight()];
    for (int i = 0; i < values.length; ++i) {
      values[i] = (short) raster.getSample(
          i % raster.getWidth(), i / raster.getWidth(), 0);
    }
    try (TreelineClient client = client()) {
      LocalizeAnswer raw = client.localize(query(stem).scene("room")
          .depth(Depth.ofValues(values, raster.getWidth(),
              raster.getHeight(), 0.001).ofSceneCamera()).build());
      LocalizeAnswer png =
          client.localize(query(stem).scene("room").build());
      assertTrue(png.localized);
      assertEquals(png.worldFromCamera, raw.worldFromCamera);
    }
  }

  @Test
  public void theSceneIsFoundAndItsSupportIsTold() throws Exception {
    try (TreelineClient client = client()) {
      LocalizeAnswer answer = client.localizeAsync(
          query(stems.get(0)).wantsCorrespondences(true).build())
          .get(60, TimeUnit.SECONDS);
      assertEquals("room", answer.scene);
      assertEquals("room", answer.candidates.get(0).scene);
      assertEquals(answer.inliers, answer.correspondences.stream()
          .filter(one -> one.inlier).count());
      LocalizeAnswer elsewhere = client.localize(query(stems.get(0))
          .scene("room").positionPrior(new LocalizeQuery.PositionPrior(
              new Vector3(50, 0, 0), 1)).build());
      assertEquals("CONTRADICTS_PRIOR", elsewhere.reason);
    }
  }

  @Test
  public void scenesHealthAndErrorsAreTheServersOwn() throws Exception {
    try (TreelineClient client = client()) {
      Scene room = client.listScenes().get(0);
      assertEquals("room", room.name);
      assertEquals("Room", room.displayName);
      assertEquals("rgbd", client.getScene("room").method);
      assertEquals(48.137, room.geoAnchor.latitudeDeg, 0);
      assertTrue(client.health().get(0).ready);
      TreelineException attic = assertThrows(TreelineException.class, () ->
          client.localize(query(stems.get(0)).scene("attic").build()));
      assertEquals(ErrorCode.NOT_FOUND, attic.code);
      assertEquals("SCENE_NOT_FOUND", attic.reason);
      TreelineException bytes = assertThrows(TreelineException.class, () ->
          client.localize(LocalizeQuery.of(new byte[] {1, 2}).scene("room")
              .build()));
      assertEquals(ErrorCode.INVALID_ARGUMENT, bytes.code);
      assertEquals("INVALID_REQUEST", bytes.reason);
      assertEquals(ErrorCode.DEADLINE_EXCEEDED, assertThrows(
          TreelineException.class, () -> client.localize(
              query(stems.get(0)).scene("room").build(), 1)).code);
      assertFalse(assertThrows(TreelineException.class, () ->
          client.geoPose(new GeoPoseQuery(1764000000000L, Files.readAllBytes(
              file(stems.get(0), "color.jpg")), 640, 480)
              .near(48.137, 11.575, 520, 20))).reason.isEmpty());
      assertEquals("NO_SCENE_NEAR", assertThrows(TreelineException.class, () ->
          client.geoPose(new GeoPoseQuery(1764000000000L, Files.readAllBytes(
              file(stems.get(0), "color.jpg")), 640, 480)
              .near(49.137, 11.575, 520, 20))).reason);
    }
  }

  @Test
  public void aRecordingInAFrameOfItsOwnComesBackToTheWorld()
      throws Exception {
    DriftParameters slow = new DriftParameters();
    slow.maxGapS = 10;
    slow.maxSpeedMps = 100;
    slow.maxTurnDegps = 7200;
    DriftCorrector corrector = new DriftCorrector(slow);
    RigidTransform worldFromDevice = new RigidTransform(
        new Quaternion(0.6, 0, 0, 0.8), new Vector3(4, -3, 1));
    BlockingQueue<TimedAnswer> answers = new LinkedBlockingQueue<>();
    DriftEstimate last = null;
    try (TreelineClient client = client();
        FrameQueue pictures = client.localizeLatest(answers::add)) {
      for (int i = 0; i < 6; ++i) {
        long timeNs = 1_000_000_000L * (i + 1);
        last = corrector.track(timeNs,
            worldFromDevice.inverse().times(truth(stems.get(i))));
        assertTrue(pictures.wantsPicture());
        pictures.push(timeNs, query(stems.get(i)).scene("room").build());
        TimedAnswer answer = answers.poll(60, TimeUnit.SECONDS);
        assertEquals(timeNs, answer.captureTimeNs);
        Fix fix = answer.answer.fix(answer.captureTimeNs);
        if (fix != null) corrector.addFix(fix);
      }
    }
    assertEquals(DriftState.LOCKED, last.state);
    assertTrue(
        distance(last.worldFromCamera, truth(stems.get(5))) < FIVE_CM);
  }

  @Test
  public void aReplicaTakesOverFromAServerThatEnds() throws Exception {
    Server gone = new Server();
    try (TreelineClient both = TreelineClient.of(
        "http://" + gone.http, "http://" + plain.http).build()) {
      LocalizeQuery query = query(stems.get(0)).scene("room").build();
      assertEquals("room", both.localize(query).scene);
      gone.process.destroy();
      gone.process.waitFor();
      assertEquals("room", both.localize(query).scene);
      assertFalse(both.health().get(0).ready);
      assertTrue(both.health().get(1).ready);
    }
  }

  @Test
  public void aPrivateAuthorityAndTokens() throws Exception {
    File keys = folder.resolve("keys").toFile();
    assertTrue(new File(keys, "public").mkdirs());
    String certificate = new File(keys, "tls.pem").getPath();
    String key = new File(keys, "tls.key").getPath();
    String signs = new File(keys, "token.key").getPath();
    try {
      run(0, "openssl", "version");
    } catch (IOException error) {
      Assume.assumeNoException("no openssl on this machine", error);
    }
    run(0, "openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes",
        "-days", "1", "-subj", "/CN=localhost", "-addext",
        "subjectAltName=DNS:localhost,IP:127.0.0.1", "-keyout", key, "-out",
        certificate);
    run(0, "openssl", "genrsa", "-out", signs, "2048");
    run(0, "openssl", "rsa", "-in", signs, "-pubout", "-out",
        new File(keys, "public/dev.pem").getPath());
    String token = run(0, environment("TREELINE_ROOT")
        + "/scripts/make-dev-token", signs, "dev", "phone", "localize").trim();
    String url = "https://" + new Server("--tls-cert", certificate,
        "--tls-key", key, "--auth-keys",
        new File(keys, "public").getPath()).http;
    LocalizeQuery query = query(stems.get(0)).scene("room").build();
    try (InputStream authority = Files.newInputStream(
        Paths.get(certificate))) {
      TreelineClient.Builder trusting =
          TreelineClient.of(url).tls(Tls.trusting(authority));
      assertEquals("room", trusting.tokenSupplier(() -> token).build()
          .localize(query).scene);
      TreelineException missing = assertThrows(TreelineException.class,
          () -> trusting.token("").build().localize(query));
      assertEquals(ErrorCode.UNAUTHENTICATED, missing.code);
      assertEquals("TOKEN_MISSING", missing.reason);
      assertEquals("TOKEN_INVALID", assertThrows(TreelineException.class,
          () -> trusting.token("forged").build().localize(query)).reason);
    }
    // The system does not trust this certificate.
    TreelineException stranger = assertThrows(TreelineException.class, () ->
        TreelineClient.of(url).token(token).retry(RetryPolicy.NEVER).build()
            .localize(query));
    assertEquals(ErrorCode.UNAVAILABLE, stranger.code);
    assertTrue(stranger.getMessage(),
        stranger.getMessage().contains("Tls.trusting"));
  }
}
