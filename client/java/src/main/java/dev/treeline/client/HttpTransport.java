package dev.treeline.client;

import java.io.IOException;

/**
 * What sends HTTP requests: {@link UrlConnectionTransport}, or an HTTP library
 * of the application's, as OkHttp. Calls are made side by side.
 */
public interface HttpTransport {
  /**
   * A call that has not begun.
   *
   * @param request to be sent, once, without following redirections
   * @return for one use
   */
  HttpCall newCall(HttpRequest request);

  /** One request on its way. */
  interface HttpCall {
    /**
     * Sends the request and reads the whole answer, of any status. It blocks;
     * it is called on a thread of the client, never on Android's main thread.
     *
     * @return the answer
     * @throws IOException if there is none: no connection, or it broke
     */
    HttpResponse execute() throws IOException;

    /**
     * Ends the call soon, by closing its connection: the server then stops
     * too. Called on another thread, and perhaps when the call has ended.
     */
    void cancel();
  }
}
