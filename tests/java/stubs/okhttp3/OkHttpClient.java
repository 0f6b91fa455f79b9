package okhttp3;

import java.util.concurrent.TimeUnit;

public class OkHttpClient {
  public Call newCall(Request request) {
    return null;
  }

  public Builder newBuilder() {
    return new Builder();
  }

  public static final class Builder {
    public Builder readTimeout(long timeout, TimeUnit unit) {
      return this;
    }

    public Builder writeTimeout(long timeout, TimeUnit unit) {
      return this;
    }

    public Builder followRedirects(boolean follow) {
      return this;
    }

    public OkHttpClient build() {
      return new OkHttpClient();
    }
  }
}
