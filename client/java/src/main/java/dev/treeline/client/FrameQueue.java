package dev.treeline.client;

import java.util.ArrayDeque;
import java.util.Deque;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.CompletionException;
import java.util.function.Function;

/**
 * The newest picture of a camera, localized again and again: a newer picture
 * replaces one that waits. Made by {@link TreelineClient#localizeLatest}. Its
 * methods may be called from any thread, and none of them waits.
 */
public final class FrameQueue implements AutoCloseable {
  /** Is told what became of the pictures. */
  public interface Listener {
    /**
     * One at a time, in the order of capture, on a thread of the client; not
     * after {@link FrameQueue#close}, but for one that has begun.
     *
     * @param answer of one picture
     */
    void onAnswer(TimedAnswer answer);
  }

  private static final class InFlight {
    final long captureTimeNs;
    final int dropped;
    CompletableFuture<LocalizeAnswer> call;
    TimedAnswer result;

    InFlight(long captureTimeNs, int dropped) {
      this.captureTimeNs = captureTimeNs;
      this.dropped = dropped;
    }
  }

  private final Function<LocalizeQuery, CompletableFuture<LocalizeAnswer>>
      localize;
  private final int maxInFlight;
  private final Listener listener;
  private final Object lock = new Object();
  private final Deque<InFlight> inFlight = new ArrayDeque<>();
  private LocalizeQuery waiting;
  private long newestNs;
  private boolean hasNewest = false;
  private int dropped = 0;
  private boolean isDelivering = false;
  private boolean isClosed = false;

  FrameQueue(
      Function<LocalizeQuery, CompletableFuture<LocalizeAnswer>> localize,
      int maxInFlight, Listener listener) {
    if (maxInFlight < 1) {
      throw new IllegalArgumentException(
          "maxInFlight: " + maxInFlight + " is not at least 1");
    }
    this.localize = localize;
    this.maxInFlight = maxInFlight;
    this.listener = listener;
  }

  /**
   * Whether a picture would be sent at once. Where it would not, nothing needs
   * to be copied or encoded.
   *
   * @return false too when it is closed
   */
  public boolean wantsPicture() {
    synchronized (lock) {
      return !isClosed && waiting == null && inFlight.size() < maxInFlight;
    }
  }

  /**
   * A picture. One that is not newer than the one before it is dropped. Closed,
   * it does nothing.
   *
   * @param captureTimeNs on the clock of the tracking, if the answer goes to
   *     DriftCorrector: {@code Frame.getTimestamp()}
   * @param query of the picture
   */
  public void push(long captureTimeNs, LocalizeQuery query) {
    synchronized (lock) {
      if (isClosed) return;
      if (hasNewest && captureTimeNs <= newestNs) {
        ++dropped;
        return;
      }
      hasNewest = true;
      newestNs = captureTimeNs;
      if (waiting != null) ++dropped;
      waiting = query;
    }
    send();
  }

  /** Cancels what is on its way, here and on the server. */
  @Override
  public void close() {
    Deque<InFlight> left;
    synchronized (lock) {
      isClosed = true;
      waiting = null;
      left = new ArrayDeque<>(inFlight);
      inFlight.clear();
    }
    for (InFlight entry : left) {
      if (entry.call != null) entry.call.cancel(true);
    }
  }

  private void send() {
    InFlight entry;
    CompletableFuture<LocalizeAnswer> call;
    synchronized (lock) {
      if (isClosed || waiting == null || inFlight.size() >= maxInFlight) {
        return;
      }
      entry = new InFlight(newestNs, dropped);
      dropped = 0;
      inFlight.add(entry);
      // It only begins the call.
      call = localize.apply(waiting);
      entry.call = call;
      waiting = null;
    }
    call.whenComplete((answer, error) -> {
      synchronized (lock) {
        entry.result = new TimedAnswer(entry.captureTimeNs, entry.dropped,
            answer, error == null ? null : exceptionOf(error));
      }
      deliver();
    });
  }

  private void deliver() {
    for (;;) {
      TimedAnswer next;
      synchronized (lock) {
        InFlight first = inFlight.peek();
        if (isDelivering || isClosed || first == null
            || first.result == null) {
          return;
        }
        inFlight.remove();
        isDelivering = true;
        next = first.result;
      }
      // What waited goes while its predecessor is looked at.
      send();
      try {
        listener.onAnswer(next);
      } catch (RuntimeException | Error error) {
        // As if the listener had a thread of its own: an app that has a fault
        // sees it.
        Thread thread = Thread.currentThread();
        thread.getUncaughtExceptionHandler().uncaughtException(thread, error);
      } finally {
        synchronized (lock) {
          isDelivering = false;
        }
      }
    }
  }

  private static TreelineException exceptionOf(Throwable error) {
    Throwable cause = error instanceof CompletionException
        && error.getCause() != null ? error.getCause() : error;
    return cause instanceof TreelineException ? (TreelineException) cause
        : new TreelineException(
            ErrorCode.INTERNAL, String.valueOf(cause), cause);
  }
}
