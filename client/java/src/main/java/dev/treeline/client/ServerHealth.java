package dev.treeline.client;

/** One server's word on itself. */
public final class ServerHealth {
  /** Its URL. */
  public final String server;
  /** Whether it says anything. */
  public final boolean reachable;
  /** Whether it answers queries. */
  public final boolean ready;
  /** What it says, or why it cannot be reached. */
  public final String detail;

  ServerHealth(String server, boolean reachable, boolean ready,
      String detail) {
    this.server = server;
    this.reachable = reachable;
    this.ready = ready;
    this.detail = detail;
  }
}
