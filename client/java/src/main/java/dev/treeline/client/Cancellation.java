package dev.treeline.client;

import java.util.HashSet;
import java.util.Set;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.TimeUnit;

/** Whether somebody still wants the answer of a call. */
final class Cancellation {
  private final CountDownLatch cancelled = new CountDownLatch(1);
  private final Set<Runnable> listeners = new HashSet<>();

  boolean isCancelled() {
    return cancelled.getCount() == 0;
  }

  void cancel() {
    Set<Runnable> told;
    synchronized (listeners) {
      cancelled.countDown();
      told = new HashSet<>(listeners);
      listeners.clear();
    }
    told.forEach(Runnable::run);
  }

  /** Told once; at once, if it is cancelled already. */
  void listen(Runnable listener) {
    synchronized (listeners) {
      if (!isCancelled()) {
        listeners.add(listener);
        return;
      }
    }
    listener.run();
  }

  void forget(Runnable listener) {
    synchronized (listeners) {
      listeners.remove(listener);
    }
  }

  void sleep(long ms) throws InterruptedException {
    cancelled.await(ms, TimeUnit.MILLISECONDS);
  }

  void throwIfCancelled() throws TreelineException {
    if (isCancelled()) throw exception();
  }

  static TreelineException exception() {
    return new TreelineException(
        ErrorCode.CANCELED, "the call was cancelled");
  }
}
