package dev.treeline.client;

/** Colour without encoding. */
public final class RgbImage {
  private static final int CHANNELS = 3;

  /** Pixels of a row. */
  public final int widthPx;
  /** Rows. */
  public final int heightPx;
  final byte[] data;

  /**
   * A picture of its pixels.
   *
   * @param widthPx of a row
   * @param heightPx rows
   * @param data R, G, B interleaved, rows from the top; not copied
   * @throws IllegalArgumentException if there are more or fewer bytes
   */
  public RgbImage(int widthPx, int heightPx, byte[] data) {
    if (data.length != CHANNELS * widthPx * heightPx) {
      throw new IllegalArgumentException(data.length + " bytes are not "
          + widthPx + "x" + heightPx + " pixels");
    }
    this.widthPx = widthPx;
    this.heightPx = heightPx;
    this.data = data;
  }
}
