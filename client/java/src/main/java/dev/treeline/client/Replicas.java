package dev.treeline.client;

import java.util.ArrayList;
import java.util.List;

/** Servers that give the same answers; the one that worked last is kept to. */
final class Replicas {
  static final class Replica {
    final String server;
    // Until when it wants to be left alone.
    private long restUntilMs = Long.MIN_VALUE;

    private Replica(String server) {
      this.server = server;
    }
  }

  private final List<Replica> replicas = new ArrayList<>();
  private int good = 0;

  Replicas(List<String> servers) {
    for (String server : servers) replicas.add(new Replica(server));
  }

  int count() {
    return replicas.size();
  }

  /** The good one, else the next that does not rest, else the one that rests
   * least long. */
  synchronized Replica choose(long nowMs) {
    Replica least = replicas.get(good);
    for (int i = 0; i < replicas.size(); ++i) {
      Replica replica = replicas.get((good + i) % replicas.size());
      if (replica.restUntilMs <= nowMs) return replica;
      if (replica.restUntilMs < least.restUntilMs) least = replica;
    }
    return least;
  }

  synchronized long restUntilMs(Replica replica) {
    return replica.restUntilMs;
  }

  synchronized void keep(Replica replica) {
    good = replicas.indexOf(replica);
    replica.restUntilMs = Long.MIN_VALUE;
  }

  synchronized void rest(Replica replica, long untilMs) {
    replica.restUntilMs = untilMs;
  }

  /** A quota is the client's own: other servers do not lend theirs. */
  synchronized void restAll(long untilMs) {
    for (Replica replica : replicas) {
      replica.restUntilMs = Math.max(replica.restUntilMs, untilMs);
    }
  }
}
