package dev.treeline.client;

import java.util.concurrent.ThreadLocalRandom;
import java.util.concurrent.TimeUnit;

/** Clock and chance, to be played in tests. */
interface Tools {
  /** Of this machine. */
  Tools SYSTEM = new Tools() {
    @Override
    public long nowMs() {
      return TimeUnit.NANOSECONDS.toMillis(System.nanoTime());
    }

    @Override
    public void sleep(long ms, Cancellation cancellation)
        throws InterruptedException {
      cancellation.sleep(ms);
    }

    @Override
    public double random() {
      return ThreadLocalRandom.current().nextDouble();
    }
  };

  /** Monotonic. */
  long nowMs();

  /** Returns after so long, or as soon as it is cancelled. */
  void sleep(long ms, Cancellation cancellation) throws InterruptedException;

  /** In [0, 1). */
  double random();
}
