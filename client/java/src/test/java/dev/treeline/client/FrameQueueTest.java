package dev.treeline.client;

import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertFalse;
import static org.junit.Assert.assertNull;
import static org.junit.Assert.assertSame;
import static org.junit.Assert.assertThrows;
import static org.junit.Assert.assertTrue;

import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.CompletableFuture;
import org.junit.Test;

public class FrameQueueTest {
  // What was asked and is not answered yet, and what was told.
  private final List<CompletableFuture<LocalizeAnswer>> asked =
      new ArrayList<>();
  private final List<TimedAnswer> told = new ArrayList<>();

  private FrameQueue queue(int maxInFlight) {
    return new FrameQueue(query -> {
      asked.add(new CompletableFuture<>());
      return asked.get(asked.size() - 1);
    }, maxInFlight, told::add);
  }

  private static LocalizeAnswer answer() throws TreelineException {
    return Convert.answer(Played.notLocalized().build(), 1);
  }

  @Test
  public void onlyTheNewestGoes() throws Exception {
    FrameQueue queue = queue(1);
    assertTrue(queue.wantsPicture());
    for (int i = 1; i <= 4; ++i) queue.push(i, Played.QUERY);
    assertFalse(queue.wantsPicture());
    assertEquals(1, asked.size());
    asked.get(0).complete(answer());
    assertEquals(2, asked.size());
    asked.get(1).complete(answer());
    assertEquals(1, told.get(0).captureTimeNs);
    assertEquals(0, told.get(0).dropped);
    assertEquals(4, told.get(1).captureTimeNs);
    assertEquals(2, told.get(1).dropped);
    assertTrue(queue.wantsPicture());
  }

  @Test
  public void whatIsNotNewerIsDropped() throws Exception {
    FrameQueue queue = queue(1);
    queue.push(5, Played.QUERY);
    queue.push(5, Played.QUERY);
    queue.push(4, Played.QUERY);
    asked.get(0).complete(answer());
    assertEquals(1, asked.size());
    queue.push(6, Played.QUERY);
    asked.get(1).complete(answer());
    assertEquals(2, told.get(1).dropped);
  }

  @Test
  public void answersComeInTheOrderOfCapture() throws Exception {
    FrameQueue queue = queue(2);
    queue.push(1, Played.QUERY);
    queue.push(2, Played.QUERY);
    queue.push(3, Played.QUERY);
    assertEquals(2, asked.size());
    asked.get(1).complete(answer());
    assertTrue(told.isEmpty());
    asked.get(0).complete(answer());
    assertEquals(2, told.size());
    assertEquals(1, told.get(0).captureTimeNs);
    assertEquals(2, told.get(1).captureTimeNs);
    assertEquals(3, asked.size());
  }

  @Test
  public void aFailedQueryEndsNothingButItself() throws Exception {
    FrameQueue queue = queue(1);
    queue.push(1, Played.QUERY);
    TreelineException error =
        new TreelineException(ErrorCode.UNAVAILABLE, "no network");
    asked.get(0).completeExceptionally(error);
    assertSame(error, told.get(0).error);
    assertNull(told.get(0).answer);
    queue.push(2, Played.QUERY);
    asked.get(1).completeExceptionally(new IllegalStateException("a fault"));
    assertEquals(ErrorCode.INTERNAL, told.get(1).error.code);
    queue.push(3, Played.QUERY);
    asked.get(2).complete(answer());
    assertNull(told.get(2).error);
  }

  @Test
  public void closedItCancelsAndTellsNoMore() throws Exception {
    FrameQueue queue = queue(1);
    queue.push(1, Played.QUERY);
    queue.push(2, Played.QUERY);
    queue.close();
    assertTrue(asked.get(0).isCancelled());
    assertFalse(queue.wantsPicture());
    queue.push(3, Played.QUERY);
    assertEquals(1, asked.size());
    assertTrue(told.isEmpty());
    queue.close();
  }

  @Test
  public void aFaultOfTheListenerIsSeenAndEndsNothing() throws Exception {
    List<Throwable> seen = new ArrayList<>();
    Thread thread = Thread.currentThread();
    Thread.UncaughtExceptionHandler before =
        thread.getUncaughtExceptionHandler();
    thread.setUncaughtExceptionHandler((own, error) -> seen.add(error));
    try {
      FrameQueue queue = new FrameQueue(
          query -> CompletableFuture.completedFuture(null), 1, answer -> {
            throw new IllegalStateException("of the app");
          });
      queue.push(1, Played.QUERY);
      queue.push(2, Played.QUERY);
      assertEquals(2, seen.size());
    } finally {
      thread.setUncaughtExceptionHandler(before);
    }
  }

  @Test
  public void overRealThreadsEachPictureIsToldOrDropped() throws Exception {
    try (PlayedServer server = new PlayedServer((request, out) -> {
      Thread.sleep(3);
      PlayedServer.message(out, Played.bytes(Played.localized()));
    }); TreelineClient client = TreelineClient.of(server.url()).build()) {
      List<TimedAnswer> all = new ArrayList<>();
      int pictures = 100;
      FrameQueue queue = client.localizeLatest(2, 60_000, answer -> {
        synchronized (all) {
          all.add(answer);
          all.notifyAll();
        }
      });
      for (int i = 1; i <= pictures; ++i) {
        queue.push(i, Played.QUERY);
        Thread.sleep(1);
      }
      synchronized (all) {
        while (all.isEmpty()
            || all.get(all.size() - 1).captureTimeNs < pictures) {
          all.wait(10_000);
        }
        int dropped = all.stream().mapToInt(one -> one.dropped).sum();
        assertEquals(pictures, all.size() + dropped);
        for (int i = 1; i < all.size(); ++i) {
          assertTrue(
              all.get(i).captureTimeNs > all.get(i - 1).captureTimeNs);
        }
      }
      queue.close();
    }
    assertThrows(IllegalArgumentException.class, () -> queue(0));
  }
}
