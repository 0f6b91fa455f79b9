package dev.treeline.client;

import java.io.ByteArrayOutputStream;
import java.io.Closeable;
import java.io.IOException;
import java.io.InputStream;
import java.io.OutputStream;
import java.net.InetAddress;
import java.net.ServerSocket;
import java.net.Socket;
import java.nio.charset.StandardCharsets;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.concurrent.CopyOnWriteArrayList;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.TimeUnit;

/** A server that says what it is told to, byte for byte. */
final class PlayedServer implements Closeable {
  /** What came. */
  static final class Request {
    final String line;
    final Map<String, String> headers = new LinkedHashMap<>();
    byte[] body = {};

    Request(String line) {
      this.line = line;
    }
  }

  /** Answers one request; what it does not say, nobody says. */
  interface Play {
    void answer(Request request, OutputStream out) throws Exception;
  }

  final List<Request> requests = new CopyOnWriteArrayList<>();
  /** A client that went away while it waited. */
  final CountDownLatch left = new CountDownLatch(1);
  private final List<Socket> sockets = new CopyOnWriteArrayList<>();
  private final ServerSocket listener;
  private final Play play;

  PlayedServer(Play play) throws IOException {
    this.play = play;
    listener = new ServerSocket(0, 16, InetAddress.getLoopbackAddress());
    Thread thread = new Thread(this::accept, "played server");
    thread.setDaemon(true);
    thread.start();
  }

  /** How many there were. */
  int connections() {
    return sockets.size();
  }

  String url() {
    return "http://127.0.0.1:" + listener.getLocalPort();
  }

  @Override
  public void close() throws IOException {
    listener.close();
    for (Socket socket : sockets) socket.close();
  }

  /** An answer with its length. */
  static void send(OutputStream out, int status, String headers, byte[] body)
      throws IOException {
    out.write(("HTTP/1.1 " + status + " Whatever\r\n" + headers
        + "Content-Length: " + body.length + "\r\n\r\n")
        .getBytes(StandardCharsets.US_ASCII));
    out.write(body);
    out.flush();
  }

  static void message(OutputStream out, byte[] body) throws IOException {
    send(out, 200, "Content-Type: application/proto\r\n", body);
  }

  static void error(OutputStream out, int status, String headers, String json)
      throws IOException {
    send(out, status, "Content-Type: application/json\r\n" + headers,
        json.getBytes(StandardCharsets.UTF_8));
  }

  /** Says nothing until the client goes away. */
  void stall(Socket socket) throws IOException {
    if (socket.getInputStream().read() < 0) left.countDown();
  }

  boolean hasBeenLeft() throws InterruptedException {
    return left.await(60, TimeUnit.SECONDS);
  }

  private void accept() {
    try {
      for (;;) {
        Socket socket = listener.accept();
        sockets.add(socket);
        Thread thread = new Thread(() -> serve(socket), "played connection");
        thread.setDaemon(true);
        thread.start();
      }
    } catch (IOException closed) {
      // The test is over.
    }
  }

  private void serve(Socket socket) {
    try (Socket own = socket) {
      InputStream in = own.getInputStream();
      for (;;) {
        Request request = read(in);
        if (request == null) return;
        requests.add(request);
        try {
          play.answer(request, own.getOutputStream());
        } catch (Stall stall) {
          stall(own);
          return;
        }
      }
    } catch (Exception closed) {
      left.countDown();
    }
  }

  /** Thrown by a play that says no more. */
  static final class Stall extends Exception {
    private static final long serialVersionUID = 1;
  }

  private static Request read(InputStream in) throws IOException {
    String first = line(in);
    if (first.isEmpty()) return null;
    Request request = new Request(first);
    for (;;) {
      String header = line(in);
      if (header.isEmpty()) break;
      int colon = header.indexOf(':');
      request.headers.put(
          header.substring(0, colon).toLowerCase(Locale.ROOT),
          header.substring(colon + 1).trim());
    }
    int length = Integer.parseInt(
        request.headers.getOrDefault("content-length", "0"));
    request.body = new byte[length];
    for (int at = 0; at < length;) {
      int count = in.read(request.body, at, length - at);
      if (count < 0) throw new IOException("half a body");
      at += count;
    }
    return request;
  }

  private static String line(InputStream in) throws IOException {
    ByteArrayOutputStream line = new ByteArrayOutputStream();
    for (;;) {
      int sign = in.read();
      if (sign < 0 || sign == '\n') {
        return new String(line.toByteArray(), StandardCharsets.US_ASCII);
      }
      if (sign != '\r') line.write(sign);
    }
  }
}
