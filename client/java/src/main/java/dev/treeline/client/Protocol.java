package dev.treeline.client;

import com.google.protobuf.InvalidProtocolBufferException;
import com.google.protobuf.MessageLite;
import com.google.protobuf.Parser;
import java.nio.charset.StandardCharsets;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;

/** The Connect protocol: docs/reference/http.md. */
final class Protocol {
  static final String RELOCALIZATION = "treeline.v1.RelocalizationService";
  static final String SCENES = "treeline.v1.SceneService";

  private static final String MESSAGE_TYPE = "application/proto";
  private static final int OK = 200;
  private static final double MS_PER_S = 1000;

  private Protocol() {}

  /** A POST of a message; headers: those of the call, which are added to. */
  static HttpRequest call(String server, String service, String method,
      MessageLite message, Map<String, String> headers, long timeoutMs) {
    headers.put("Content-Type", MESSAGE_TYPE);
    headers.put("Accept", MESSAGE_TYPE);
    headers.put("Connect-Protocol-Version", "1");
    headers.put(
        "Connect-Timeout-Ms", Long.toString(Math.max(1, timeoutMs)));
    return new HttpRequest("POST", server + "/" + service + "/" + method,
        headers, message.toByteArray(), timeoutMs);
  }

  static <T> T answer(HttpResponse response, Parser<T> parser)
      throws TreelineException {
    if (response.status != OK) throw error(response);
    String type = response.header("Content-Type");
    if (!type.toLowerCase(Locale.ROOT).startsWith(MESSAGE_TYPE)) {
      throw notOurs("the answer is '" + type + "', not " + MESSAGE_TYPE);
    }
    try {
      return parser.parseFrom(response.body);
    } catch (InvalidProtocolBufferException error) {
      throw new TreelineException(
          ErrorCode.INTERNAL, "the answer is no message", error);
    }
  }

  static Object json(HttpResponse response) throws TreelineException {
    if (response.status != OK) throw error(response);
    try {
      return Json.parse(text(response));
    } catch (Json.JsonException error) {
      throw notOurs("the answer is no JSON");
    }
  }

  /** The error of an answer that is none. */
  static TreelineException error(HttpResponse response) {
    long retryAfterMs = seconds(response.header("Retry-After"));
    Object body;
    try {
      body = Json.parse(text(response));
    } catch (Json.JsonException error) {
      // The status alone tells.
      body = null;
    }
    Object code = Json.at(body, "code");
    if (!(code instanceof String)) {
      return new TreelineException(ErrorCode.ofHttp(response.status),
          "the server answered with status " + response.status, "",
          new LinkedHashMap<>(), retryAfterMs, null);
    }
    Object info = debug(body, "google.rpc.ErrorInfo");
    // It is exact; Retry-After has whole seconds.
    Object delay = Json.at(debug(body, "google.rpc.RetryInfo"), "retryDelay");
    if (delay instanceof String) {
      long exactMs = milliseconds((String) delay);
      if (exactMs >= 0) retryAfterMs = exactMs;
    }
    Map<String, String> metadata = new LinkedHashMap<>();
    Object told = Json.at(info, "metadata");
    if (told instanceof Map) {
      ((Map<?, ?>) told).forEach((name, value) ->
          metadata.put(String.valueOf(name), String.valueOf(value)));
    }
    return new TreelineException(ErrorCode.ofConnect((String) code),
        textOf(Json.at(body, "message")), textOf(Json.at(info, "reason")),
        metadata, retryAfterMs, null);
  }

  // The readable form of a detail; null: there is none.
  private static Object debug(Object body, String type) {
    Object details = Json.at(body, "details");
    if (!(details instanceof List)) return null;
    for (Object detail : (List<?>) details) {
      if (type.equals(Json.at(detail, "type"))) {
        return Json.at(detail, "debug");
      }
    }
    return null;
  }

  private static String textOf(Object value) {
    return value instanceof String ? (String) value : "";
  }

  // Of "3"; -1: it is none. Nine digits are thirty years.
  private static long seconds(String text) {
    return text.matches("\\d{1,9}") ? 1000 * Long.parseLong(text) : -1;
  }

  // Of "0.250s", as JSON has durations.
  private static long milliseconds(String text) {
    return text.matches("\\d{1,9}(\\.\\d{1,9})?s")
        ? (long) Math.ceil(MS_PER_S
            * Double.parseDouble(text.substring(0, text.length() - 1)))
        : -1;
  }

  private static String text(HttpResponse response) {
    return new String(response.body, StandardCharsets.UTF_8);
  }

  private static TreelineException notOurs(String what) {
    return new TreelineException(ErrorCode.UNKNOWN, what
        + ": this is no treeline-server; a portal of the network, perhaps");
  }
}
