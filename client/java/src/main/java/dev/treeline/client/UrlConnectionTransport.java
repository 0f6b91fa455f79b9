package dev.treeline.client;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.io.InputStream;
import java.io.OutputStream;
import java.net.HttpURLConnection;
import java.net.URL;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import javax.net.ssl.HttpsURLConnection;
import javax.net.ssl.SSLSocketFactory;

/**
 * The HttpURLConnection of Android and of every Java. Connections are kept and
 * used again.
 */
public final class UrlConnectionTransport implements HttpTransport {
  // Far more than the largest map of a scene.
  static final int MAX_RESPONSE_BYTES = 64 << 20;
  private static final int CHUNK_BYTES = 1 << 14;

  /** It is larger than any answer of Treeline's. */
  static final class TooLargeException extends IOException {
    private static final long serialVersionUID = 1;

    TooLargeException() {
      super("the answer is larger than " + MAX_RESPONSE_BYTES + " bytes");
    }
  }

  private final SSLSocketFactory tls;

  /** Trusts the authorities that the system trusts. */
  public UrlConnectionTransport() {
    this(null);
  }

  /**
   * With TLS of one's own: {@link Tls}.
   *
   * @param tls null: the system's
   */
  public UrlConnectionTransport(SSLSocketFactory tls) {
    this.tls = tls;
  }

  @Override
  public HttpCall newCall(HttpRequest request) {
    return new Call(request);
  }

  private final class Call implements HttpCall {
    private final HttpRequest request;
    private HttpURLConnection connection;
    private boolean isCancelled = false;

    Call(HttpRequest request) {
      this.request = request;
    }

    @Override
    public HttpResponse execute() throws IOException {
      HttpURLConnection opened =
          (HttpURLConnection) new URL(request.url).openConnection();
      synchronized (this) {
        if (isCancelled) throw new IOException("cancelled");
        connection = opened;
      }
      prepare(opened);
      if (request.body != null) {
        opened.setDoOutput(true);
        try (OutputStream out = opened.getOutputStream()) {
          out.write(request.body);
        }
      }
      int status = opened.getResponseCode();
      Map<String, String> headers = new HashMap<>();
      for (Map.Entry<String, List<String>> header
          : opened.getHeaderFields().entrySet()) {
        // The status line has no name.
        if (header.getKey() != null) {
          headers.put(header.getKey(), header.getValue().get(0));
        }
      }
      try (InputStream in = status < HttpURLConnection.HTTP_BAD_REQUEST
          ? opened.getInputStream() : opened.getErrorStream()) {
        HttpResponse response = new HttpResponse(status, headers, read(in));
        // Some Javas take the end of a connection for the end of an answer.
        String length = response.header("Content-Length");
        if (!length.isEmpty()
            && !length.equals(Integer.toString(response.body.length))) {
          throw new IOException("the answer ended early");
        }
        return response;
      }
    }

    private void prepare(HttpURLConnection opened) throws IOException {
      if (tls != null && opened instanceof HttpsURLConnection) {
        ((HttpsURLConnection) opened).setSSLSocketFactory(tls);
      }
      int timeoutMs =
          (int) Math.max(1, Math.min(Integer.MAX_VALUE, request.timeoutMs));
      opened.setConnectTimeout(timeoutMs);
      opened.setReadTimeout(timeoutMs);
      opened.setInstanceFollowRedirects(false);
      opened.setUseCaches(false);
      opened.setRequestMethod(request.method);
      request.headers.forEach(opened::setRequestProperty);
    }

    @Override
    public void cancel() {
      HttpURLConnection opened;
      synchronized (this) {
        isCancelled = true;
        opened = connection;
      }
      if (opened != null) opened.disconnect();
    }
  }

  private static byte[] read(InputStream in) throws IOException {
    ByteArrayOutputStream body = new ByteArrayOutputStream();
    // An error without a body has no stream.
    if (in == null) return body.toByteArray();
    byte[] chunk = new byte[CHUNK_BYTES];
    for (;;) {
      int count = in.read(chunk);
      if (count < 0) return body.toByteArray();
      if (body.size() + count > MAX_RESPONSE_BYTES) {
        throw new TooLargeException();
      }
      body.write(chunk, 0, count);
    }
  }
}
