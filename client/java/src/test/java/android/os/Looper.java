package android.os;

/** Android's, as far as the client asks it. */
public final class Looper {
  private static final Looper MAIN = new Looper();
  /** Whether this test plays the main thread. */
  public static final ThreadLocal<Boolean> IS_MAIN =
      ThreadLocal.withInitial(() -> false);

  private Looper() {}

  public static Looper getMainLooper() {
    return MAIN;
  }

  public static Looper myLooper() {
    return IS_MAIN.get() ? MAIN : null;
  }
}
