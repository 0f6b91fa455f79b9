package dev.treeline.client;

import java.lang.reflect.Method;

/** Android's main thread, which draws and must not wait. */
final class MainThread {
  private MainThread() {}

  /** Throws an IllegalStateException on it. */
  static void refuse() {
    if (isCurrent()) {
      throw new IllegalStateException("this call blocks, and this is Android's "
          + "main thread: use the one that ends with Async");
    }
  }

  private static boolean isCurrent() {
    try {
      Class<?> looper = Class.forName("android.os.Looper");
      Method main = looper.getMethod("getMainLooper");
      Method mine = looper.getMethod("myLooper");
      Object current = mine.invoke(null);
      return current != null && current == main.invoke(null);
    } catch (ReflectiveOperationException error) {
      // Not Android.
      return false;
    }
  }
}
