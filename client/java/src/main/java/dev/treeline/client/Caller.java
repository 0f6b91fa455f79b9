package dev.treeline.client;

import dev.treeline.client.HttpTransport.HttpCall;
import dev.treeline.client.Replicas.Replica;
import java.io.IOException;
import java.net.SocketTimeoutException;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.Executor;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.TimeoutException;
import javax.net.ssl.SSLHandshakeException;

/** Trying again, and elsewhere, within one deadline. */
final class Caller {
  /** One attempt: asks a server, within so long. */
  interface Attempt<T> {
    T ask(Exchange exchange) throws TreelineException;
  }

  private final HttpTransport transport;
  private final Executor network;
  private final Tools tools;

  /** network: has a thread for each task, at once. */
  Caller(HttpTransport transport, Executor network, Tools tools) {
    this.transport = transport;
    this.network = network;
    this.tools = tools;
  }

  /** One server, for the time of one attempt. */
  final class Exchange {
    final String server;
    final long timeoutMs;
    private final Cancellation cancellation;

    private Exchange(
        String server, long timeoutMs, Cancellation cancellation) {
      this.server = server;
      this.timeoutMs = timeoutMs;
      this.cancellation = cancellation;
    }

    /** Whatever the transport does, the wait ends with the time. */
    HttpResponse send(HttpRequest request) throws TreelineException {
      HttpCall call = transport.newCall(request);
      CompletableFuture<HttpResponse> done = new CompletableFuture<>();
      Runnable cancel = () -> done.completeExceptionally(
          Cancellation.exception());
      cancellation.listen(cancel);
      boolean hasAnswer = false;
      try {
        network.execute(() -> execute(call, done));
        HttpResponse response = done.get(timeoutMs, TimeUnit.MILLISECONDS);
        hasAnswer = true;
        return response;
      } catch (TimeoutException error) {
        throw timeIsUp(server);
      } catch (InterruptedException error) {
        Thread.currentThread().interrupt();
        throw new TreelineException(
            ErrorCode.CANCELED, "the thread was interrupted", error);
      } catch (ExecutionException error) {
        throw errorOf(error.getCause(), server);
      } finally {
        cancellation.forget(cancel);
        // Closing a connection is network, which Android forbids some threads.
        if (!hasAnswer) network.execute(call::cancel);
      }
    }
  }

  private static void execute(
      HttpCall call, CompletableFuture<HttpResponse> done) {
    try {
      done.complete(call.execute());
    } catch (Throwable error) {
      // Whoever waits is told, also of too little memory.
      done.completeExceptionally(error);
    }
  }

  /**
   * Calls `attempt` until it has an answer, cannot be retried, or the time is
   * up. A wait that would pass the deadline is not begun: the last error is
   * thrown. attemptTimeoutMs: of one attempt, where there is another server.
   */
  <T> T call(Attempt<T> attempt, Replicas replicas, RetryPolicy policy,
      long timeoutMs, long attemptTimeoutMs, Cancellation cancellation)
      throws TreelineException {
    long deadlineMs = tools.nowMs() + timeoutMs;
    for (int tried = 1;; ++tried) {
      cancellation.throwIfCancelled();
      Replica replica = replicas.choose(tools.nowMs());
      waitFor(replica, replicas, deadlineMs, cancellation);
      long leftMs = deadlineMs - tools.nowMs();
      if (leftMs <= 0) throw timeIsUp(replica.server);
      long ownMs = replicas.count() == 1 ? leftMs
          : Math.min(leftMs, Math.max(1, attemptTimeoutMs));
      try {
        T answer = attempt.ask(
            new Exchange(replica.server, ownMs, cancellation));
        replicas.keep(replica);
        return answer;
      } catch (TreelineException error) {
        cancellation.throwIfCancelled();
        long nowMs = tools.nowMs();
        boolean wasCutShort = error.code == ErrorCode.DEADLINE_EXCEEDED
            && nowMs < deadlineMs && ownMs < leftMs;
        if (!wasCutShort && !RetryPolicy.isWorthRetrying(error)) throw error;
        long untilMs =
            nowMs + policy.pauseMs(error, tried, tools.random());
        if (error.code == ErrorCode.RESOURCE_EXHAUSTED) {
          replicas.restAll(untilMs);
        } else {
          replicas.rest(replica, untilMs);
        }
        long nextMs = Math.max(
            replicas.restUntilMs(replicas.choose(nowMs)), nowMs);
        if (tried >= policy.maxAttempts || nextMs >= deadlineMs) throw error;
      }
    }
  }

  private void waitFor(Replica replica, Replicas replicas, long deadlineMs,
      Cancellation cancellation) throws TreelineException {
    long nowMs = tools.nowMs();
    long untilMs = replicas.restUntilMs(replica);
    if (untilMs <= nowMs) return;
    if (untilMs >= deadlineMs) {
      throw new TreelineException(ErrorCode.UNAVAILABLE,
          replica.server + " wants to be asked later than the deadline");
    }
    try {
      tools.sleep(untilMs - nowMs, cancellation);
    } catch (InterruptedException error) {
      Thread.currentThread().interrupt();
      throw new TreelineException(
          ErrorCode.CANCELED, "the thread was interrupted", error);
    }
    cancellation.throwIfCancelled();
  }

  private static TreelineException timeIsUp(String server) {
    return new TreelineException(
        ErrorCode.DEADLINE_EXCEEDED, server + " did not answer in time");
  }

  private static TreelineException errorOf(Throwable cause, String server) {
    if (cause instanceof TreelineException) return (TreelineException) cause;
    if (cause instanceof SocketTimeoutException) {
      return new TreelineException(ErrorCode.DEADLINE_EXCEEDED,
          server + " did not answer in time", cause);
    }
    if (cause instanceof UrlConnectionTransport.TooLargeException) {
      return new TreelineException(
          ErrorCode.INTERNAL, server + ": " + cause.getMessage(), cause);
    }
    if (cause instanceof IOException) {
      String hint = cause instanceof SSLHandshakeException
          ? " (its certificate: see Tls.trusting)" : "";
      return new TreelineException(ErrorCode.UNAVAILABLE,
          server + " cannot be reached: " + cause + hint, cause);
    }
    // Android without the permission INTERNET, for one.
    return new TreelineException(
        ErrorCode.INTERNAL, "the transport failed: " + cause, cause);
  }
}
