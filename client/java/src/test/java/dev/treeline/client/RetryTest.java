package dev.treeline.client;

import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertThrows;
import static org.junit.Assert.assertTrue;

import java.util.Arrays;
import java.util.Collections;
import java.util.concurrent.atomic.AtomicInteger;
import org.junit.Test;

public class RetryTest {
  private static String error(String code, String delay) {
    return "{\"code\":\"" + code + "\",\"details\":[{"
        + "\"type\":\"google.rpc.RetryInfo\",\"debug\":{\"retryDelay\":\""
        + delay + "\"}}]}";
  }

  private static TreelineClient client(
      Tools tools, PlayedServer... servers) {
    return TreelineClient.of(Arrays.stream(servers).map(PlayedServer::url)
        .toArray(String[]::new)).tools(tools).build();
  }

  private static PlayedServer failing(
      int times, int status, String headers, String body) throws Exception {
    AtomicInteger count = new AtomicInteger();
    return new PlayedServer((request, out) -> {
      if (count.incrementAndGet() <= times) {
        PlayedServer.error(out, status, headers, body);
      } else {
        PlayedServer.message(out, Played.bytes(Played.localized()));
      }
    });
  }

  @Test
  public void whatIsUnavailableIsAskedAgain() throws Exception {
    Played.PlayedTools tools = new Played.PlayedTools();
    try (PlayedServer server = failing(2, 503, "", "{}")) {
      assertTrue(client(tools, server).localize(Played.QUERY).localized);
      assertEquals(3, server.requests.size());
      assertEquals(Arrays.asList(25L, 75L), tools.sleptMs);
    }
  }

  @Test
  public void whatIsWrongIsNot() throws Exception {
    Played.PlayedTools tools = new Played.PlayedTools();
    try (PlayedServer server = failing(
        9, 400, "", "{\"code\":\"invalid_argument\"}")) {
      assertEquals(ErrorCode.INVALID_ARGUMENT, assertThrows(
          TreelineException.class,
          () -> client(tools, server).localize(Played.QUERY)).code);
      assertEquals(1, server.requests.size());
    }
  }

  @Test
  public void theServersOwnTimeIsKept() throws Exception {
    Played.PlayedTools tools = new Played.PlayedTools();
    try (PlayedServer server = failing(1, 429, "Retry-After: 3\r\n",
        "{\"code\":\"resource_exhausted\"}")) {
      assertTrue(client(tools, server).localize(Played.QUERY).localized);
      assertEquals(Collections.singletonList(3000L), tools.sleptMs);
    }
    // Without a time it is a message that is too large.
    try (PlayedServer server = failing(
        1, 429, "", "{\"code\":\"resource_exhausted\"}")) {
      assertEquals(ErrorCode.RESOURCE_EXHAUSTED, assertThrows(
          TreelineException.class,
          () -> client(tools, server).localize(Played.QUERY)).code);
    }
  }

  @Test
  public void aWaitBeyondTheDeadlineIsNotBegun() throws Exception {
    Played.PlayedTools tools = new Played.PlayedTools();
    try (PlayedServer server = failing(
        9, 503, "", error("unavailable", "60s"))) {
      TreelineClient client = client(tools, server);
      TreelineException error = assertThrows(
          TreelineException.class, () -> client.localize(Played.QUERY));
      assertEquals(60_000, error.retryAfterMs);
      assertTrue(tools.sleptMs.isEmpty());
      // And the next call does not ask at all.
      assertEquals(ErrorCode.UNAVAILABLE, assertThrows(
          TreelineException.class, () -> client.localize(Played.QUERY)).code);
      assertEquals(1, server.requests.size());
    }
  }

  @Test
  public void attemptsEnd() throws Exception {
    Played.PlayedTools tools = new Played.PlayedTools();
    try (PlayedServer server = failing(9, 503, "", "{}")) {
      assertThrows(TreelineException.class,
          () -> client(tools, server).localize(Played.QUERY));
      assertEquals(4, server.requests.size());
    }
    assertThrows(IllegalArgumentException.class,
        () -> new RetryPolicy(0, 1, 1, 1));
  }

  @Test
  public void aReplicaTakesOverAndIsKeptTo() throws Exception {
    Played.PlayedTools tools = new Played.PlayedTools();
    try (PlayedServer bad = failing(9, 503, "", "{}");
        PlayedServer good = failing(0, 0, "", "")) {
      TreelineClient client = client(tools, bad, good);
      client.localize(Played.QUERY);
      client.localize(Played.QUERY);
      assertEquals(1, bad.requests.size());
      assertEquals(2, good.requests.size());
      assertTrue(tools.sleptMs.isEmpty());
    }
  }

  @Test
  public void aServerThatHangsLeavesTimeForAnother() throws Exception {
    try (PlayedServer hung = new PlayedServer((request, out) -> {
      throw new PlayedServer.Stall();
    }); PlayedServer good = failing(0, 0, "", "")) {
      TreelineClient client = TreelineClient.of(hung.url(), good.url())
          .attemptTimeoutMs(300).retry(new RetryPolicy(100, 1, 1, 1)).build();
      assertTrue(client.localize(Played.QUERY, 60_000).localized);
      assertTrue(hung.requests.size() >= 1);
    }
  }

  @Test
  public void aQuotaIsNotEvaded() throws Exception {
    Played.PlayedTools tools = new Played.PlayedTools();
    try (PlayedServer first = failing(
            1, 429, "", error("resource_exhausted", "2s"));
        PlayedServer second = failing(0, 0, "", "")) {
      assertTrue(
          client(tools, first, second).localize(Played.QUERY).localized);
      assertEquals(Collections.singletonList(2000L), tools.sleptMs);
    }
  }

  @Test
  public void aWaitIsOverWhenNobodyWantsTheAnswer() throws Exception {
    try (PlayedServer server = failing(
        9, 503, "", error("unavailable", "9s"))) {
      TreelineClient client = TreelineClient.of(server.url()).build();
      java.util.concurrent.CompletableFuture<LocalizeAnswer> future =
          client.localizeAsync(Played.QUERY);
      while (server.requests.isEmpty()) Thread.sleep(1);
      long startNs = System.nanoTime();
      client.close();
      assertThrows(java.util.concurrent.ExecutionException.class,
          () -> future.get());
      assertTrue(System.nanoTime() - startNs < 8_000_000_000L);
    }
  }
}
