package dev.treeline.client;

import com.google.protobuf.MessageLite;
import com.google.protobuf.Parser;
import dev.treeline.proto.GetSceneMapRequest;
import dev.treeline.proto.GetSceneMapResponse;
import dev.treeline.proto.GetSceneRequest;
import dev.treeline.proto.GetSceneResponse;
import dev.treeline.proto.ListRecentQueriesRequest;
import dev.treeline.proto.ListRecentQueriesResponse;
import dev.treeline.proto.ListScenesRequest;
import dev.treeline.proto.ListScenesResponse;
import dev.treeline.proto.LocalizeRequest;
import dev.treeline.proto.LocalizeResponse;
import java.net.URI;
import java.net.URISyntaxException;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.Executor;
import java.util.concurrent.Executors;
import java.util.function.Supplier;
import java.util.regex.Pattern;
import javax.net.ssl.SSLSocketFactory;

/**
 * Asks treeline-server where a camera is. Calls may run side by side, from any
 * thread. Those that end with Async do not wait: their future fails with a
 * {@link TreelineException}, and {@code cancel} of it cancels the call, here
 * and on the server. The others block, and are refused on Android's main
 * thread.
 */
public final class TreelineClient implements AutoCloseable {
  private static final long DEFAULT_TIMEOUT_MS = 10_000;
  private static final Pattern SCENE_NAME = Pattern.compile("[\\w.-]{1,128}");
  private static final Pattern TOKEN = Pattern.compile("[\\x21-\\x7e]+");
  private static final String GEO_POSE_TYPE =
      "application/vnd.oscp+json;version=2.0";

  private final Replicas replicas;
  private final List<String> servers;
  private final TokenSupplier token;
  private final long timeoutMs;
  private final long attemptTimeoutMs;
  private final RetryPolicy policy;
  private final boolean sceneHeader;
  private final Supplier<String> traceparent;
  private final Tools tools;
  private final Executor threads;
  private final Caller caller;
  private final Set<Cancellation> calls = ConcurrentHashMap.newKeySet();
  private volatile boolean isClosed = false;

  private TreelineClient(Builder b, List<String> servers) {
    this.servers = servers;
    replicas = new Replicas(servers);
    token = b.token;
    timeoutMs = b.timeoutMs;
    attemptTimeoutMs = b.attemptTimeoutMs;
    policy = b.policy;
    sceneHeader = b.sceneHeader;
    traceparent = b.traceparent;
    tools = b.tools;
    threads = Executors.newCachedThreadPool(task -> {
      Thread thread = new Thread(task, "treeline");
      // It keeps no program from ending.
      thread.setDaemon(true);
      return thread;
    });
    caller = new Caller(b.transport, threads, tools);
  }

  /**
   * A client of one server, or of several replicas with the same scenes: the
   * one that answered last is kept to, and the others take over when it does
   * not.
   *
   * @param servers base URLs of their HTTP ports:
   *     "https://treeline.example.com"
   * @return what the rest is told
   */
  public static Builder of(String... servers) {
    return new Builder(servers);
  }

  /**
   * Where one picture was taken. "Not localized" is an answer, not an error.
   *
   * @param query the picture
   * @return where, or why not
   * @throws TreelineException if there is no answer
   */
  public LocalizeAnswer localize(LocalizeQuery query)
      throws TreelineException {
    return localize(query, timeoutMs);
  }

  /**
   * The same within another time.
   *
   * @param query the picture
   * @param ownTimeoutMs of the whole call, retries included
   * @return where, or why not
   * @throws TreelineException if there is no answer
   */
  public LocalizeAnswer localize(LocalizeQuery query, long ownTimeoutMs)
      throws TreelineException {
    return block(cancellation -> localize(query, ownTimeoutMs, cancellation));
  }

  /**
   * The same without waiting.
   *
   * @param query the picture
   * @return where, or why not
   */
  public CompletableFuture<LocalizeAnswer> localizeAsync(LocalizeQuery query) {
    return localizeAsync(query, timeoutMs);
  }

  /**
   * The same within another time.
   *
   * @param query the picture
   * @param ownTimeoutMs of the whole call, retries included
   * @return where, or why not
   */
  public CompletableFuture<LocalizeAnswer> localizeAsync(
      LocalizeQuery query, long ownTimeoutMs) {
    return begin(cancellation -> localize(query, ownTimeoutMs, cancellation));
  }

  /**
   * Localizes the newest picture of a camera, again and again, one at a time.
   *
   * @param listener is told the answers
   * @return takes the pictures; to be closed
   */
  public FrameQueue localizeLatest(FrameQueue.Listener listener) {
    return localizeLatest(1, timeoutMs, listener);
  }

  /**
   * The same with several pictures on their way.
   *
   * @param maxInFlight at a time, at least 1
   * @param ownTimeoutMs of each picture
   * @param listener is told the answers
   * @return takes the pictures; to be closed
   */
  public FrameQueue localizeLatest(
      int maxInFlight, long ownTimeoutMs, FrameQueue.Listener listener) {
    return new FrameQueue(
        query -> localizeAsync(query, ownTimeoutMs), maxInFlight, listener);
  }

  /**
   * Every scene that this token may see.
   *
   * @return by name
   * @throws TreelineException if there is no answer
   */
  public List<Scene> listScenes() throws TreelineException {
    return block(this::listScenes);
  }

  /**
   * The same without waiting.
   *
   * @return by name
   */
  public CompletableFuture<List<Scene>> listScenesAsync() {
    return begin(this::listScenes);
  }

  /**
   * One scene.
   *
   * @param name of it
   * @return as the server has it
   * @throws TreelineException NOT_FOUND: there is no such scene
   */
  public Scene getScene(String name) throws TreelineException {
    return block(cancellation -> getScene(name, cancellation));
  }

  /**
   * The same without waiting.
   *
   * @param name of it
   * @return as the server has it
   */
  public CompletableFuture<Scene> getSceneAsync(String name) {
    return begin(cancellation -> getScene(name, cancellation));
  }

  /**
   * Points, keyframes and coverage of a scene. It blocks.
   *
   * @param name of the scene
   * @param maxPoints at most so many, up to 200000; 0: 50000
   * @param wantsCoverage the first who asks waits until it is computed
   * @return what its model knows
   * @throws TreelineException FAILED_PRECONDITION: it has no keyframes
   */
  public SceneMap getSceneMap(
      String name, int maxPoints, boolean wantsCoverage)
      throws TreelineException {
    GetSceneMapRequest request = GetSceneMapRequest.newBuilder()
        .setScene(name).setMaxPoints(maxPoints)
        .setIncludeCoverage(wantsCoverage).build();
    return block(cancellation -> Convert.sceneMap(call(Protocol.SCENES,
        "GetSceneMap", request, GetSceneMapResponse.parser(), name, timeoutMs,
        cancellation)));
  }

  /**
   * What became of the latest queries in a scene. It blocks.
   *
   * @param name of the scene
   * @return the newest first
   * @throws TreelineException FAILED_PRECONDITION: the server keeps none
   */
  public List<RecentQuery> listRecentQueries(String name)
      throws TreelineException {
    ListRecentQueriesRequest request =
        ListRecentQueriesRequest.newBuilder().setScene(name).build();
    ListRecentQueriesResponse response =
        block(cancellation -> call(Protocol.SCENES, "ListRecentQueries",
            request, ListRecentQueriesResponse.parser(), name, timeoutMs,
            cancellation));
    List<RecentQuery> queries = new ArrayList<>();
    for (dev.treeline.proto.RecentQuery query : response.getQueriesList()) {
      queries.add(Convert.recentQuery(query));
    }
    return queries;
  }

  /**
   * Where one picture was taken on the Earth, by the GeoPose Protocol.
   *
   * @param query the picture
   * @return where
   * @throws TreelineException NOT_FOUND: it is not localized; the protocol has
   *     no such answer
   */
  public GeoPoseAnswer geoPose(GeoPoseQuery query) throws TreelineException {
    return block(cancellation -> geoPose(query, cancellation));
  }

  /**
   * The same without waiting.
   *
   * @param query the picture
   * @return where
   */
  public CompletableFuture<GeoPoseAnswer> geoPoseAsync(GeoPoseQuery query) {
    return begin(cancellation -> geoPose(query, cancellation));
  }

  /**
   * Whether each server is there and answers queries. It blocks.
   *
   * @return in the order of the servers
   * @throws TreelineException CANCELED, if the client is closed meanwhile
   */
  public List<ServerHealth> health() throws TreelineException {
    return block(cancellation -> {
      List<CompletableFuture<ServerHealth>> asked = new ArrayList<>();
      for (String server : servers) {
        asked.add(CompletableFuture.supplyAsync(
            () -> healthOf(server, cancellation), threads));
      }
      List<ServerHealth> all = new ArrayList<>();
      for (CompletableFuture<ServerHealth> health : asked) {
        all.add(health.join());
      }
      cancellation.throwIfCancelled();
      return all;
    });
  }

  /** Cancels all calls. Those that come later are cancelled at once. */
  @Override
  public void close() {
    isClosed = true;
    calls.forEach(Cancellation::cancel);
  }

  private interface Work<T> {
    T run(Cancellation cancellation) throws TreelineException;
  }

  private <T> T block(Work<T> work) throws TreelineException {
    MainThread.refuse();
    return run(work, new Cancellation());
  }

  private <T> CompletableFuture<T> begin(Work<T> work) {
    CompletableFuture<T> future = new CompletableFuture<>();
    Cancellation cancellation = new Cancellation();
    future.whenComplete((answer, error) -> {
      if (future.isCancelled()) cancellation.cancel();
    });
    threads.execute(() -> {
      try {
        future.complete(run(work, cancellation));
      } catch (TreelineException | RuntimeException | Error error) {
        future.completeExceptionally(error);
      }
    });
    return future;
  }

  private <T> T run(Work<T> work, Cancellation cancellation)
      throws TreelineException {
    calls.add(cancellation);
    try {
      if (isClosed) cancellation.cancel();
      return work.run(cancellation);
    } finally {
      calls.remove(cancellation);
    }
  }

  private LocalizeAnswer localize(LocalizeQuery query, long ownTimeoutMs,
      Cancellation cancellation) throws TreelineException {
    long startMs = tools.nowMs();
    LocalizeRequest request = Convert.request(query);
    LocalizeResponse response = call(Protocol.RELOCALIZATION, "Localize",
        request, LocalizeResponse.parser(), query.scene, ownTimeoutMs,
        cancellation);
    return Convert.answer(response, tools.nowMs() - startMs);
  }

  private List<Scene> listScenes(Cancellation cancellation)
      throws TreelineException {
    return Convert.each(call(Protocol.SCENES, "ListScenes",
        ListScenesRequest.getDefaultInstance(), ListScenesResponse.parser(),
        "", timeoutMs, cancellation).getScenesList(), Convert::scene);
  }

  private Scene getScene(String name, Cancellation cancellation)
      throws TreelineException {
    GetSceneResponse response = call(Protocol.SCENES, "GetScene",
        GetSceneRequest.newBuilder().setScene(name).build(),
        GetSceneResponse.parser(), name, timeoutMs, cancellation);
    if (!response.hasScene()) {
      throw new TreelineException(
          ErrorCode.INTERNAL, "the server sent no scene");
    }
    return Convert.scene(response.getScene());
  }

  private GeoPoseAnswer geoPose(GeoPoseQuery query, Cancellation cancellation)
      throws TreelineException {
    byte[] body = query.json();
    return attempt(exchange -> {
      Map<String, String> headers = headers("");
      headers.put("Content-Type", "application/json");
      headers.put("Accept", GEO_POSE_TYPE);
      return new GeoPoseAnswer(Protocol.json(exchange.send(new HttpRequest(
          "POST", exchange.server + "/geopose", headers, body,
          exchange.timeoutMs))));
    }, timeoutMs, cancellation);
  }

  private ServerHealth healthOf(String server, Cancellation cancellation) {
    try {
      HttpResponse response = caller.call(
          exchange -> exchange.send(new HttpRequest("GET", server + "/readyz",
              Collections.emptyMap(), null, exchange.timeoutMs)),
          new Replicas(Collections.singletonList(server)), RetryPolicy.NEVER,
          timeoutMs, timeoutMs, cancellation);
      String detail = new String(response.body, StandardCharsets.UTF_8).trim();
      return new ServerHealth(server, true, response.status == 200, detail);
    } catch (TreelineException error) {
      return new ServerHealth(server, false, false, error.getMessage());
    }
  }

  private <T> T call(String service, String method, MessageLite request,
      Parser<T> parser, String scene, long ownTimeoutMs,
      Cancellation cancellation) throws TreelineException {
    return attempt(exchange -> Protocol.answer(
        exchange.send(Protocol.call(exchange.server, service, method, request,
            headers(scene), exchange.timeoutMs)), parser),
        ownTimeoutMs, cancellation);
  }

  private <T> T attempt(Caller.Attempt<T> attempt, long ownTimeoutMs,
      Cancellation cancellation) throws TreelineException {
    return caller.call(attempt, replicas, policy, ownTimeoutMs,
        attemptTimeoutMs > 0 ? attemptTimeoutMs : ownTimeoutMs / 2,
        cancellation);
  }

  private Map<String, String> headers(String scene) throws TreelineException {
    Map<String, String> headers = new LinkedHashMap<>();
    String bearer;
    try {
      bearer = token.get();
    } catch (Exception error) {
      throw new TreelineException(ErrorCode.UNAUTHENTICATED,
          "the supplier of tokens has none", error);
    }
    if (bearer != null && !bearer.isEmpty()) {
      // What refuses it would say it, in a log.
      if (!TOKEN.matcher(bearer).matches()) {
        throw new TreelineException(ErrorCode.UNAUTHENTICATED,
            "the token has signs that no header has: a line end, perhaps");
      }
      headers.put("Authorization", "Bearer " + bearer);
    }
    // What is no name goes in the request alone, which the server answers.
    if (sceneHeader && SCENE_NAME.matcher(scene).matches()) {
      headers.put("X-Treeline-Scene", scene);
    }
    String span = traceparent.get();
    if (Traceparent.isOne(span)) headers.put("traceparent", span);
    return headers;
  }

  // Without a slash at the end.
  private static String baseUrl(String server) {
    URI url;
    try {
      url = new URI(server);
    } catch (URISyntaxException error) {
      throw new IllegalArgumentException(server + ": is no URL", error);
    }
    boolean isHttp = "http".equalsIgnoreCase(url.getScheme())
        || "https".equalsIgnoreCase(url.getScheme());
    if (!isHttp || url.getHost() == null || url.getQuery() != null
        || url.getFragment() != null || url.getUserInfo() != null) {
      throw new IllegalArgumentException(
          server + ": is not a base URL of http or https");
    }
    return server.replaceAll("/+$", "");
  }

  /** How the servers are asked. All of it may be left out. */
  public static final class Builder {
    private final String[] servers;
    private TokenSupplier token = () -> "";
    private long timeoutMs = DEFAULT_TIMEOUT_MS;
    private long attemptTimeoutMs = 0;
    private RetryPolicy policy = RetryPolicy.DEFAULT;
    private boolean sceneHeader = false;
    private Supplier<String> traceparent = () -> "";
    private HttpTransport transport = new UrlConnectionTransport();
    private Tools tools = Tools.SYSTEM;

    private Builder(String[] servers) {
      this.servers = servers.clone();
    }

    /**
     * A bearer token.
     *
     * @param bearer that does not change
     * @return this
     */
    public Builder token(String bearer) {
      token = () -> bearer;
      return this;
    }

    /**
     * What gives bearer tokens.
     *
     * @param supplier asked before each attempt
     * @return this
     */
    public Builder tokenSupplier(TokenSupplier supplier) {
      token = supplier;
      return this;
    }

    /**
     * Of a call, retries included. Else it is 10 s.
     *
     * @param wholeMs positive
     * @return this
     */
    public Builder timeoutMs(long wholeMs) {
      timeoutMs = wholeMs;
      return this;
    }

    /**
     * Of one attempt, where there are several servers. Else it is half of the
     * whole, so that one that hangs does not take all the time.
     *
     * @param oneMs positive
     * @return this
     */
    public Builder attemptTimeoutMs(long oneMs) {
      attemptTimeoutMs = oneMs;
      return this;
    }

    /**
     * How often and how soon a call is made again.
     *
     * @param wanted else it is {@link RetryPolicy#DEFAULT}
     * @return this
     */
    public Builder retry(RetryPolicy wanted) {
      policy = wanted;
      return this;
    }

    /**
     * Names the scene in the header X-Treeline-Scene too, so that a balancer
     * can choose the server by it.
     *
     * @param wanted else it does not
     * @return this
     */
    public Builder sceneHeader(boolean wanted) {
      sceneHeader = wanted;
      return this;
    }

    /**
     * Gives the span that a call belongs to, as W3C has it, whose child the
     * server's becomes. What is none is left out.
     *
     * @param supplier asked before each attempt; {@link Traceparent#create}
     *     makes one
     * @return this
     */
    public Builder traceparent(Supplier<String> supplier) {
      traceparent = supplier;
      return this;
    }

    /**
     * TLS with certificates of one's own: {@link Tls}.
     *
     * @param factory of its connections
     * @return this
     */
    public Builder tls(SSLSocketFactory factory) {
      transport = new UrlConnectionTransport(factory);
      return this;
    }

    /**
     * What sends the requests, instead of HttpURLConnection.
     *
     * @param wanted an HTTP library of the application's
     * @return this
     */
    public Builder transport(HttpTransport wanted) {
      transport = wanted;
      return this;
    }

    /** Clock and chance, for tests. */
    Builder tools(Tools played) {
      tools = played;
      return this;
    }

    /**
     * The client.
     *
     * @return with threads of its own, as many as there are calls
     * @throws IllegalArgumentException for what is no URL, and for no server
     */
    public TreelineClient build() {
      Set<String> urls = new LinkedHashSet<>();
      for (String server : servers) urls.add(baseUrl(server));
      if (urls.isEmpty()) {
        throw new IllegalArgumentException("there is no server");
      }
      return new TreelineClient(this, new ArrayList<>(urls));
    }
  }
}
