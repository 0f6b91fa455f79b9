package dev.treeline.client;

import java.security.SecureRandom;
import java.util.regex.Pattern;

/** The distributed trace that calls belong to, as W3C has it. */
public final class Traceparent {
  private static final Pattern PATTERN = Pattern.compile(
      "00-(?!0{32})[0-9a-f]{32}-(?!0{16})[0-9a-f]{16}-[0-9a-f]{2}");
  private static final SecureRandom RANDOM = new SecureRandom();
  private static final int TRACE_BYTES = 16;
  private static final int SPAN_BYTES = 8;

  private Traceparent() {}

  /**
   * Of a new trace, for programs that record no spans of their own.
   *
   * @param sampled whether the server is asked to record its
   * @return of version 00
   */
  public static String create(boolean sampled) {
    for (;;) {
      String made = "00-" + randomHex(TRACE_BYTES) + "-"
          + randomHex(SPAN_BYTES) + (sampled ? "-01" : "-00");
      // 0 is no id.
      if (isOne(made)) return made;
    }
  }

  static boolean isOne(String text) {
    return text != null && PATTERN.matcher(text).matches();
  }

  private static String randomHex(int count) {
    byte[] drawn = new byte[count];
    RANDOM.nextBytes(drawn);
    StringBuilder hex = new StringBuilder();
    for (byte one : drawn) hex.append(String.format("%02x", one & 0xff));
    return hex.toString();
  }
}
