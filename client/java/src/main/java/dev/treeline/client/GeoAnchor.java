package dev.treeline.client;

import dev.treeline.geometry.Quaternion;


/** Where a scene's world lies on the Earth: its origin there, WGS84. */
public final class GeoAnchor {
  /** To the north. */
  public final double latitudeDeg;
  /** To the east. */
  public final double longitudeDeg;
  /** Above the ellipsoid. */
  public final double heightM;
  /** Turns the world's axes into East, North, Up. */
  public final Quaternion enuFromWorld;

  GeoAnchor(double latitudeDeg, double longitudeDeg, double heightM,
      Quaternion enuFromWorld) {
    this.latitudeDeg = latitudeDeg;
    this.longitudeDeg = longitudeDeg;
    this.heightM = heightM;
    this.enuFromWorld = enuFromWorld;
  }
}
