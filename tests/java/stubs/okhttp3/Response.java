package okhttp3;

import java.io.Closeable;

public final class Response implements Closeable {
  public int code() {
    return 0;
  }

  public Headers headers() {
    return new Headers();
  }

  public String header(String name) {
    return null;
  }

  public ResponseBody body() {
    return null;
  }

  @Override
  public void close() {}
}
