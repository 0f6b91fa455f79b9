package dev.treeline.fusion;

import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertNotNull;
import static org.junit.Assert.assertNull;
import static org.junit.Assert.assertTrue;

import dev.treeline.client.JsonFile;
import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;
import java.io.File;
import java.lang.reflect.Field;
import java.util.Arrays;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import org.junit.Test;

/** The corrector does what client/fusion_vectors say; the environment's
 * TREELINE_FUSION_VECTORS names the folder. */
public class VectorsTest {
  private static final double TOLERANCE = 1e-6;
  private static final int FILES = 13;
  private static final long NS_PER_MS = 1_000_000;

  private static File[] files() {
    String folder = System.getenv("TREELINE_FUSION_VECTORS");
    assertNotNull("TREELINE_FUSION_VECTORS is not set", folder);
    File[] files = new File(folder).listFiles(
        (parent, name) -> name.endsWith(".json"));
    Arrays.sort(files);
    return files;
  }

  @Test
  public void everyFileHasTheSameStatesAndIsNearTheTruth() throws Exception {
    File[] files = files();
    assertTrue(files.length >= FILES);
    for (File file : files) {
      int claimed = replay(file.getName(), JsonFile.read(file));
      assertTrue(file.getName(), claimed > 10);
    }
  }

  @Test
  public void theDefaultsAreThoseOfTheOthers() throws Exception {
    for (File file : files()) {
      if (!file.getName().equals("clean_walk.json")) continue;
      DriftParameters told = parameters(JsonFile.read(file));
      for (Field field : DriftParameters.class.getFields()) {
        assertEquals(field.getName(), field.get(told),
            field.get(new DriftParameters()));
      }
      return;
    }
    throw new AssertionError("there is no clean_walk.json");
  }

  // max_single_fix_m -> maxSingleFixM; a file has all of them.
  private static DriftParameters parameters(Map<String, Object> vectors)
      throws ReflectiveOperationException {
    DriftParameters parameters = new DriftParameters();
    Map<?, ?> told = (Map<?, ?>) vectors.get("parameters");
    assertEquals(DriftParameters.class.getFields().length, told.size());
    for (Map.Entry<?, ?> one : told.entrySet()) {
      StringBuilder name = new StringBuilder();
      for (String word : ((String) one.getKey()).split("_")) {
        name.append(name.length() == 0 ? word
            : word.substring(0, 1).toUpperCase(Locale.ROOT)
                + word.substring(1));
      }
      DriftParameters.class.getField(name.toString())
          .setDouble(parameters, (Double) one.getValue());
    }
    return parameters;
  }

  private static long timeNs(Object ms) {
    return Math.round((Double) ms) * NS_PER_MS;
  }

  private static RigidTransform pose(Object numbers) {
    double[] n = doubles(numbers);
    return new RigidTransform(
        new Quaternion(n[0], n[1], n[2], n[3]).normalized(),
        new Vector3(n[4], n[5], n[6]));
  }

  private static double[] doubles(Object list) {
    return ((List<?>) list).stream().mapToDouble(one -> (Double) one)
        .toArray();
  }

  private static String word(Enum<?> value) {
    return value.name().toLowerCase(Locale.ROOT);
  }

  // Returns how many times a claim was put to the test.
  private static int replay(String name, Map<String, Object> vectors)
      throws ReflectiveOperationException {
    DriftCorrector corrector = new DriftCorrector(parameters(vectors));
    int claimed = 0;
    int index = 0;
    for (Object entry : (List<?>) vectors.get("events")) {
      Map<?, ?> event = (Map<?, ?>) entry;
      Map<?, ?> expected = (Map<?, ?>) event.get("expect");
      String where = name + ", event " + index++;
      switch ((String) event.get("kind")) {
        case "reset":
          corrector.trackingReset();
          assertEquals(where, expected.get("state"), word(corrector.state()));
          break;
        case "fix":
          assertEquals(where, expected.get("verdict"),
              word(corrector.addFix(new Fix(
                  timeNs(event.get("capture_time_ms")),
                  pose(event.get("world_from_camera")),
                  doubles(event.get("covariance")),
                  (Double) event.get("confidence")))));
          assertEquals(where, expected.get("state"), word(corrector.state()));
          break;
        default:
          DriftEstimate estimate = corrector.track(
              timeNs(event.get("time_ms")),
              pose(event.get("device_from_camera")));
          check(where, expected, estimate);
          claimed += checkClaims(where, vectors, event, estimate);
      }
    }
    return claimed;
  }

  private static void check(
      String where, Map<?, ?> expected, DriftEstimate estimate) {
    assertEquals(where, 8, expected.size());
    assertEquals(where, expected.get("state"), word(estimate.state));
    assertEquals(where, expected.get("snapped"), estimate.snapped);
    assertEquals(
        where, expected.get("tracking_broke"), estimate.trackingBroke);
    assertEquals(where, (Double) expected.get("contradicting_views"),
        estimate.contradictingViews, 0);
    checkNumber(
        where, expected.get("position_sigma_m"), estimate.positionSigmaM);
    checkNumber(
        where, expected.get("rotation_sigma_deg"), estimate.rotationSigmaDeg);
    checkNumber(
        where, expected.get("since_good_fix_s"), estimate.sinceGoodFixS);
    Object world = expected.get("world_from_device");
    if (world == null) {
      assertNull(where, estimate.worldFromDevice);
      return;
    }
    double[] n = doubles(world);
    Quaternion q = estimate.worldFromDevice.rotation;
    Vector3 t = estimate.worldFromDevice.translationM;
    double[] actual = {q.w, q.x, q.y, q.z, t.x, t.y, t.z};
    for (int i = 0; i < n.length; ++i) {
      assertEquals(where, n[i], actual[i], TOLERANCE);
    }
  }

  private static void checkNumber(
      String where, Object expected, double actual) {
    assertEquals(where, expected == null ? Double.NaN : (Double) expected,
        actual, TOLERANCE);
  }

  private static int checkClaims(String where, Map<String, Object> vectors,
      Map<?, ?> event, DriftEstimate estimate) {
    if (estimate.state != DriftState.LOCKED) return 0;
    int claimed = 0;
    double timeMs = (Double) event.get("time_ms");
    double errorM = estimate.worldFromCamera.translationM.minus(
        pose(event.get("true_world_from_camera")).translationM).norm();
    for (Object entry : (List<?>) vectors.get("claims")) {
      Map<?, ?> claim = (Map<?, ?>) entry;
      if (timeMs < (Double) claim.get("from_ms")
          || timeMs > (Double) claim.get("to_ms")) {
        continue;
      }
      ++claimed;
      assertTrue(where + ": " + errorM + " m from the truth",
          errorM <= (Double) claim.get("max_error_m"));
    }
    return claimed;
  }
}
