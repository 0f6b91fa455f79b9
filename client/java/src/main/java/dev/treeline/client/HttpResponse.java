package dev.treeline.client;

import java.util.Locale;
import java.util.Map;
import java.util.TreeMap;

/** What a {@link HttpTransport} has as an answer. */
public final class HttpResponse {
  /** As 200. */
  public final int status;
  /** Empty if there was none. */
  public final byte[] body;
  private final Map<String, String> headers = new TreeMap<>();

  /**
   * An answer of its parts.
   *
   * @param status as 200
   * @param headers by any writing of their names
   * @param body which is not copied
   */
  public HttpResponse(int status, Map<String, String> headers, byte[] body) {
    this.status = status;
    this.body = body;
    headers.forEach(
        (name, value) -> this.headers.put(lower(name), value));
  }

  /**
   * One of the headers.
   *
   * @param name in any writing
   * @return empty: there is none
   */
  public String header(String name) {
    String value = headers.get(lower(name));
    return value == null ? "" : value;
  }

  private static String lower(String name) {
    return name.toLowerCase(Locale.ROOT);
  }
}
