package dev.treeline.client;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;

/**
 * Why a call has no answer. "Not localized" is no error: it is an answer.
 */
public final class TreelineException extends Exception {
  private static final long serialVersionUID = 1;

  /** What kind of error it is. */
  public final ErrorCode code;
  /** Stable, for programs: docs/reference/service.md has the table. Empty
   * where no server said anything. */
  public final String reason;
  /** When the server wants to be asked again, from now; negative: it did not
   * say. */
  public final long retryAfterMs;
  /** What metadata() gives. */
  private final LinkedHashMap<String, String> metadata;

  TreelineException(ErrorCode code, String message) {
    this(code, message, null);
  }

  TreelineException(ErrorCode code, String message, Throwable cause) {
    this(code, message, "", Collections.emptyMap(), -1, cause);
  }

  TreelineException(ErrorCode code, String message, String reason,
      Map<String, String> metadata, long retryAfterMs, Throwable cause) {
    super(message, cause);
    this.code = code;
    this.reason = reason;
    this.metadata = new LinkedHashMap<>(metadata);
    this.retryAfterMs = retryAfterMs;
  }

  /**
   * What else the server says of it, as the inliers of a picture without a
   * GeoPose.
   *
   * @return not to be changed
   */
  public Map<String, String> metadata() {
    return Collections.unmodifiableMap(metadata);
  }
}
