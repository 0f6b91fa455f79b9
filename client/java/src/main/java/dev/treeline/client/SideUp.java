package dev.treeline.client;

/** Which side of the picture, as it is sent, is up in the world. */
public enum SideUp {
  /** It is upright. */
  TOP,
  /** Its right side. */
  RIGHT,
  /** It stands on its head. */
  BOTTOM,
  /** Its left side. */
  LEFT;

  // Of EXIF's Orientation, by its values: upright, half a turn, and a quarter.
  private static final int EXIF_UPRIGHT = 1;
  private static final int EXIF_HALF_TURN = 3;
  private static final int EXIF_TURN_CLOCKWISE = 6;
  private static final int EXIF_TURN_ANTICLOCKWISE = 8;

  /**
   * Of what {@code ExifInterface.TAG_ORIENTATION} says of a picture whose
   * pixels are sent without it: decoded and encoded anew, but not turned.
   *
   * @param exif 1, 3, 6 or 8
   * @return the side that is up
   * @throws IllegalArgumentException for mirrored pictures
   */
  public static SideUp ofExif(int exif) {
    switch (exif) {
      case EXIF_UPRIGHT: return TOP;
      case EXIF_HALF_TURN: return BOTTOM;
      // To be turned clockwise until it is upright: its left side is up.
      case EXIF_TURN_CLOCKWISE: return LEFT;
      case EXIF_TURN_ANTICLOCKWISE: return RIGHT;
      default: throw new IllegalArgumentException(
          "EXIF's orientation " + exif + " is not 1, 3, 6 or 8");
    }
  }
}
