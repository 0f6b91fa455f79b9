package dev.treeline.client;

import java.util.Locale;

/** Status codes, as docs/reference/service.md has them. */
public enum ErrorCode {
  /** By whoever asked. */
  CANCELED,
  /** An answer that is none of Treeline's. */
  UNKNOWN,
  /** The request; the message names the field. */
  INVALID_ARGUMENT,
  /** The time was up. */
  DEADLINE_EXCEEDED,
  /** No such scene or version. */
  NOT_FOUND,
  /** It is there already. */
  ALREADY_EXISTS,
  /** The token does not allow it. */
  PERMISSION_DENIED,
  /** A quota, or a message that is too large. */
  RESOURCE_EXHAUSTED,
  /** The scene is not loaded, or lacks what was asked for. */
  FAILED_PRECONDITION,
  /** It gave way to another. */
  ABORTED,
  /** Beyond what there is. */
  OUT_OF_RANGE,
  /** The server knows no such call. */
  UNIMPLEMENTED,
  /** A fault of the server, or of this client. */
  INTERNAL,
  /** It cannot be reached, is overloaded or stopping. */
  UNAVAILABLE,
  /** The scene's model file is corrupt. */
  DATA_LOSS,
  /** No token, or one that is not valid. */
  UNAUTHENTICATED;

  // As the Connect protocol writes it: "invalid_argument".
  static ErrorCode ofConnect(String name) {
    for (ErrorCode code : values()) {
      if (code.name().toLowerCase(Locale.ROOT).equals(name)) return code;
    }
    return UNKNOWN;
  }

  // Of answers that are not the server's own, as of a proxy.
  static ErrorCode ofHttp(int status) {
    switch (status) {
      case 400: return INTERNAL;
      case 401: return UNAUTHENTICATED;
      case 403: return PERMISSION_DENIED;
      case 404: return UNIMPLEMENTED;
      case 429: case 502: case 503: case 504: return UNAVAILABLE;
      default: return UNKNOWN;
    }
  }
}
