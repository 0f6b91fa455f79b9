package dev.treeline.client;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;

/** What a {@link HttpTransport} sends. */
public final class HttpRequest {
  /** GET or POST. */
  public final String method;
  /** With scheme, host and path. */
  public final String url;
  /** Of each name one. */
  public final Map<String, String> headers;
  /** Null: GET has none. */
  public final byte[] body;
  /** The client waits no longer. */
  public final long timeoutMs;

  HttpRequest(String method, String url, Map<String, String> headers,
      byte[] body, long timeoutMs) {
    this.method = method;
    this.url = url;
    this.headers =
        Collections.unmodifiableMap(new LinkedHashMap<>(headers));
    this.body = body;
    this.timeoutMs = timeoutMs;
  }
}
