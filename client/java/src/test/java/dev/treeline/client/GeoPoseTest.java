package dev.treeline.client;

import static org.junit.Assert.assertArrayEquals;
import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertThrows;

import dev.treeline.camera.Camera;
import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.Vector3;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;
import java.util.Base64;
import java.util.List;
import java.util.Map;
import org.junit.Test;

public class GeoPoseTest {
  private static final double ROUNDING = 1e-9;

  private static String answer(double x, double y, double z, double w) {
    return "{\"id\":\"1\",\"timestamp\":1764000000123,\"type\":\"geopose\","
        + "\"accuracy\":{\"position\":0.028,\"orientation\":1.6},"
        + "\"geopose\":{\"position\":{\"lat\":48.1,\"lon\":11.5,\"h\":523},"
        + "\"quaternion\":{\"x\":" + x + ",\"y\":" + y + ",\"z\":" + z
        + ",\"w\":" + w + "}}}";
  }

  @Test
  public void theRequestIsThatOfTheProtocol() throws Exception {
    GeoPoseQuery query =
        new GeoPoseQuery(1764000000123L, new byte[] {1, 2, 3}, 640, 480)
            .camera(Camera.pinhole(640, 480, 585, 586, 319.5, 239.5))
            .turnClockwiseDeg(90).near(48.1, 11.5, 520, 20);
    Map<String, Object> json = JsonFile.parse(
        new String(query.json(), StandardCharsets.UTF_8));
    assertEquals(1764000000123.0, json.get("timestamp"));
    Object reading = ((List<?>) Json.at(
        json, "sensorReadings", "cameraReadings")).get(0);
    assertArrayEquals(new byte[] {1, 2, 3}, Base64.getDecoder().decode(
        (String) Json.at(reading, "imageBytes")));
    // The protocol's pixels: half a pixel more.
    assertEquals(Arrays.asList(585.0, 586.0, 320.0, 240.0),
        Json.at(reading, "params", "modelParams"));
    assertEquals(90.0, Json.at(reading, "imageOrientation", "rotation"));
    Object place = ((List<?>) Json.at(
        json, "sensorReadings", "geolocationReadings")).get(0);
    assertEquals(11.5, Json.at(place, "longitude"));
    assertThrows(IllegalArgumentException.class,
        () -> query.turnClockwiseDeg(45));
    Map<String, Object> bare = JsonFile.parse(new String(
        new GeoPoseQuery(1, new byte[] {1}, 2, 2).json(),
        StandardCharsets.UTF_8));
    assertEquals(1, ((List<?>) bare.get("sensors")).size());
  }

  @Test
  public void aLevelCameraThatLooksNorthHasNoRotation() throws Exception {
    try (PlayedServer server = new PlayedServer((request, out) ->
            PlayedServer.error(out, 200, "", answer(0, 0, 0, 1)));
        TreelineClient client = TreelineClient.of(server.url()).build()) {
      GeoPoseAnswer pose = client.geoPose(
          new GeoPoseQuery(1, new byte[] {1}, 640, 480));
      assertEquals("POST /geopose HTTP/1.1", server.requests.get(0).line);
      assertEquals(1764000000123L, pose.captureTimeMs);
      assertEquals(48.1, pose.latitudeDeg, 0);
      assertEquals(523, pose.heightM, 0);
      assertEquals(0.028, pose.positionAccuracyM, 0);
      // The optical axis points north, what is below in the picture down.
      Vector3 forward = pose.enuFromCamera.rotate(new Vector3(0, 0, 1));
      assertEquals(
          0, forward.minus(new Vector3(0, 1, 0)).norm(), ROUNDING);
      Vector3 down = pose.enuFromCamera.rotate(new Vector3(0, 1, 0));
      assertEquals(0, down.minus(new Vector3(0, 0, -1)).norm(), ROUNDING);
      assertEquals(0,
          pose.enuFromDevice().angleToRad(Quaternion.IDENTITY), ROUNDING);
      assertArrayEquals(
          new double[] {0, 0, 0}, pose.yawPitchRollDeg(), ROUNDING);
    }
  }

  @Test
  public void anglesTurnAboutUpFirst() throws Exception {
    Quaternion q = Quaternion.fromAxisAngle(new Vector3(0, 0, 0.5))
        .times(Quaternion.fromAxisAngle(new Vector3(0, 0.3, 0)))
        .times(Quaternion.fromAxisAngle(new Vector3(-0.2, 0, 0)));
    double[] angles = new GeoPoseAnswer(Json.parse(
        answer(q.x, q.y, q.z, q.w))).yawPitchRollDeg();
    assertArrayEquals(new double[] {Math.toDegrees(0.5),
        Math.toDegrees(0.3), Math.toDegrees(-0.2)}, angles, ROUNDING);
  }

  @Test
  public void withoutAPoseThereIsAnError() throws Exception {
    try (PlayedServer server = new PlayedServer((request, out) ->
            PlayedServer.error(out, 422, "", "{\"code\":\"not_found\","
                + "\"message\":\"no pose\",\"details\":[{"
                + "\"type\":\"google.rpc.ErrorInfo\",\"debug\":{"
                + "\"reason\":\"TOO_FEW_INLIERS\","
                + "\"metadata\":{\"inliers\":\"4\"}}}]}"));
        TreelineClient client = TreelineClient.of(server.url()).build()) {
      TreelineException error = assertThrows(TreelineException.class, () ->
          client.geoPose(new GeoPoseQuery(1, new byte[] {1}, 640, 480)));
      assertEquals(ErrorCode.NOT_FOUND, error.code);
      assertEquals("TOO_FEW_INLIERS", error.reason);
      assertEquals("4", error.metadata().get("inliers"));
    }
    assertThrows(TreelineException.class, () -> new GeoPoseAnswer(
        Json.parse("{\"timestamp\":1,\"geopose\":{}}")));
    assertThrows(TreelineException.class, () -> new GeoPoseAnswer(
        Json.parse("[]")));
  }
}
