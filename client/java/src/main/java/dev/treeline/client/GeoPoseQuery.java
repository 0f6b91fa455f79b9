package dev.treeline.client;

import dev.treeline.camera.Camera;
import dev.treeline.camera.Colmap;
import java.nio.charset.StandardCharsets;
import java.util.Base64;

/** A picture whose place on the Earth is asked, by the GeoPose Protocol. */
public final class GeoPoseQuery {
  private static final String PRIVACY = "\"privacy\":{\"dataRetention\":[],"
      + "\"dataAcceptableUse\":[],\"dataSanitizationApplied\":[],"
      + "\"dataSanitizationRequested\":[]}";
  private static final int QUARTER_TURN_DEG = 90;
  private static final int FULL_TURN_DEG = 360;

  private final long captureTimeMs;
  private final byte[] color;
  private final int widthPx;
  private final int heightPx;
  private Camera camera;
  private int turnClockwiseDeg = 0;
  private double[] place;

  /**
   * A picture of a file.
   *
   * @param captureTimeMs since 1970, as System.currentTimeMillis()
   * @param color a JPEG or PNG file; not copied
   * @param widthPx its size
   * @param heightPx its size
   */
  public GeoPoseQuery(
      long captureTimeMs, byte[] color, int widthPx, int heightPx) {
    this.captureTimeMs = captureTimeMs;
    this.color = color;
    this.widthPx = widthPx;
    this.heightPx = heightPx;
  }

  /**
   * That took the picture. Else it is the scene's.
   *
   * @param took with Treeline's pixels
   * @return this
   */
  public GeoPoseQuery camera(Camera took) {
    camera = took;
    return this;
  }

  /**
   * How far the picture is to be turned to be upright.
   *
   * @param clockwiseDeg 0, 90, 180 or 270
   * @return this
   */
  public GeoPoseQuery turnClockwiseDeg(int clockwiseDeg) {
    if (clockwiseDeg < 0 || clockwiseDeg >= FULL_TURN_DEG
        || clockwiseDeg % QUARTER_TURN_DEG != 0) {
      throw new IllegalArgumentException(
          clockwiseDeg + " degrees are not 0, 90, 180 or 270");
    }
    turnClockwiseDeg = clockwiseDeg;
    return this;
  }

  /**
   * About where it was taken, as {@code android.location.Location} has it.
   *
   * @param latitudeDeg to the north
   * @param longitudeDeg to the east
   * @param altitudeM above the ellipsoid
   * @param accuracyM about how wrong it is
   * @return this
   */
  public GeoPoseQuery near(double latitudeDeg, double longitudeDeg,
      double altitudeM, double accuracyM) {
    place = new double[] {latitudeDeg, longitudeDeg, altitudeM, accuracyM};
    return this;
  }

  /** The body of the request. */
  byte[] json() {
    String head = "{\"id\":\"" + captureTimeMs + "\",\"timestamp\":"
        + captureTimeMs + ",\"type\":\"geopose\",\"sensors\":["
        + "{\"id\":\"camera\",\"type\":\"camera\"}"
        + (place == null ? ""
            : ",{\"id\":\"place\",\"type\":\"geolocation\"}")
        + "],\"sensorReadings\":{\"cameraReadings\":[{"
        + reading("camera") + ",\"sequenceNumber\":0,\"imageFormat\":\"JPG\","
        + "\"size\":[" + widthPx + "," + heightPx + "],"
        + "\"imageOrientation\":{\"mirrored\":false,\"rotation\":"
        + turnClockwiseDeg + "}" + cameraJson() + ",\"imageBytes\":\"";
    String tail = "\"}]" + placeJson() + "}}";
    byte[] picture = Base64.getEncoder().encode(color);
    byte[] first = head.getBytes(StandardCharsets.UTF_8);
    byte[] last = tail.getBytes(StandardCharsets.UTF_8);
    byte[] body = new byte[first.length + picture.length + last.length];
    System.arraycopy(first, 0, body, 0, first.length);
    System.arraycopy(picture, 0, body, first.length, picture.length);
    System.arraycopy(
        last, 0, body, first.length + picture.length, last.length);
    return body;
  }

  private String reading(String sensor) {
    return "\"timestamp\":" + captureTimeMs + ",\"sensorId\":\"" + sensor
        + "\"," + PRIVACY;
  }

  private String cameraJson() {
    if (camera == null) return "";
    StringBuilder made = new StringBuilder(",\"params\":{\"model\":")
        .append(Json.quoted(camera.model)).append(",\"modelParams\":[");
    String comma = "";
    for (double parameter : Colmap.parameters(camera)) {
      made.append(comma).append(parameter);
      comma = ",";
    }
    return made.append("]}").toString();
  }

  private String placeJson() {
    if (place == null) return "";
    return ",\"geolocationReadings\":[{" + reading("place")
        + ",\"latitude\":" + place[0] + ",\"longitude\":" + place[1]
        + ",\"altitude\":" + place[2] + ",\"accuracy\":" + place[3]
        + ",\"altitudeAccuracy\":" + place[3]
        + ",\"heading\":0,\"speed\":0}]";
  }
}
