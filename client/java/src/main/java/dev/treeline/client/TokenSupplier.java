package dev.treeline.client;

/** Has bearer tokens; asked before each attempt, on a thread of the client. */
public interface TokenSupplier {
  /**
   * The token of now.
   *
   * @return empty: none is sent
   * @throws Exception if there is none: the call fails as UNAUTHENTICATED
   */
  String get() throws Exception;
}
