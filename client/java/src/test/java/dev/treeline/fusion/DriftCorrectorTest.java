package dev.treeline.fusion;

import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertFalse;
import static org.junit.Assert.assertNotNull;
import static org.junit.Assert.assertNull;
import static org.junit.Assert.assertThrows;
import static org.junit.Assert.assertTrue;

import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;
import org.junit.Test;

/** What client/fusion_vectors do not say; the TypeScript client's tests have
 * the same. */
public class DriftCorrectorTest {
  private static final long MS = 1_000_000;
  // The truth: the world is the device's frame, moved by 10 m.
  private static final RigidTransform WORLD = at(10);
  private static final double[] COVARIANCE =
      GaussianPose.diagonal(1e-4, Math.toRadians(0.3) * Math.toRadians(0.3));

  private static RigidTransform at(double x) {
    return new RigidTransform(Quaternion.IDENTITY, new Vector3(x, 0, 0));
  }

  // A device whose camera moves along x, and fixes of it.
  private static final class Device {
    final DriftCorrector corrector;
    long timeNs = 0;
    double xM = 0;

    Device(DriftParameters parameters) {
      corrector = new DriftCorrector(parameters);
      corrector.track(0, at(0));
    }

    Device() {
      this(new DriftParameters());
    }

    DriftEstimate step() {
      timeNs += 100 * MS;
      xM += 0.1;
      return corrector.track(timeNs, at(xM));
    }

    DriftEstimate walk(int steps) {
      for (int i = 1; i < steps; ++i) step();
      return step();
    }

    FixVerdict fix(RigidTransform world) {
      return corrector.addFix(
          new Fix(timeNs, world.times(at(xM)), COVARIANCE, 0.97));
    }

    void lock() {
      assertEquals(FixVerdict.HELD, fix(WORLD));
      step();
      assertEquals(FixVerdict.LOCKED, fix(WORLD));
      assertEquals(DriftState.LOCKED, step().state);
    }
  }

  @Test
  public void oneFixIsNoWorldTwoThatAgreeAre() {
    Device device = new Device();
    assertEquals(DriftState.SEARCHING, device.step().state);
    assertEquals(FixVerdict.HELD, device.fix(WORLD));
    DriftEstimate alone = device.step();
    assertEquals(DriftState.TENTATIVE, alone.state);
    assertNull(alone.worldFromDevice);
    assertTrue(Double.isNaN(alone.sinceGoodFixS));
    assertEquals(FixVerdict.LOCKED, device.fix(WORLD));
    DriftEstimate estimate = device.step();
    assertTrue(estimate.snapped);
    assertEquals(0, estimate.worldFromDevice.translationM
        .minus(WORLD.translationM).norm(), 1e-9);
    assertEquals(0.1, estimate.sinceGoodFixS, 1e-9);
    assertFalse(device.step().snapped);
  }

  @Test
  public void aPictureCountsOnce() {
    Device device = new Device();
    assertEquals(FixVerdict.HELD, device.fix(WORLD));
    assertEquals(FixVerdict.IGNORED_REPEATED, device.fix(WORLD));
    assertEquals(DriftState.TENTATIVE, device.corrector.state());
  }

  @Test
  public void aWorldIsGivenUpForThreeViewsThatAgree() {
    Device device = new Device();
    device.lock();
    assertEquals(FixVerdict.HELD, device.fix(at(14)));
    device.walk(4);
    assertEquals(FixVerdict.HELD, device.fix(at(14)));
    assertEquals(2, device.walk(4).contradictingViews);
    assertEquals(FixVerdict.JUMPED, device.fix(at(14)));
    assertTrue(device.step().snapped);
  }

  @Test
  public void withoutGoodFixesTheWorldIsLost() {
    DriftParameters parameters = new DriftParameters();
    parameters.lostAfterS = 2;
    Device device = new Device(parameters);
    // They were copied.
    parameters.lostAfterS = 1000;
    device.lock();
    DriftEstimate late = device.walk(25);
    assertEquals(DriftState.LOST, late.state);
    assertNotNull(late.worldFromDevice);
    assertEquals(FixVerdict.APPLIED, device.fix(WORLD));
    assertEquals(DriftState.LOCKED, device.step().state);
  }

  @Test
  public void anAppThatWasPausedBeginsAnew() {
    Device device = new Device();
    device.lock();
    device.timeNs += 5000 * MS;
    DriftEstimate estimate = device.step();
    assertTrue(estimate.trackingBroke);
    assertEquals(DriftState.SEARCHING, estimate.state);
    // A fix of before the pause is of no use.
    assertEquals(FixVerdict.IGNORED_UNTRACKED, device.corrector.addFix(
        new Fix(100 * MS, WORLD, COVARIANCE, 0.97)));
  }

  @Test
  public void whatIsNoFixIsRefusedAndChangesNothing() {
    Device device = new Device();
    double[] indefinite = COVARIANCE.clone();
    indefinite[0] = -1;
    double[] asymmetric = COVARIANCE.clone();
    asymmetric[1] = 5e-5;
    for (double[] bad : new double[][] {{1}, indefinite, asymmetric}) {
      assertThrows(IllegalArgumentException.class, () ->
          device.corrector.addFix(new Fix(0, WORLD, bad, 0.9)));
    }
    for (double bad : new double[] {1.1, -0.1, Double.NaN}) {
      assertThrows(IllegalArgumentException.class, () ->
          device.corrector.addFix(new Fix(0, WORLD, COVARIANCE, bad)));
    }
    RigidTransform long2 =
        new RigidTransform(new Quaternion(2, 0, 0, 0), Vector3.ZERO);
    assertThrows(IllegalArgumentException.class, () ->
        device.corrector.addFix(new Fix(0, long2, COVARIANCE, 0.9)));
    assertThrows(IllegalArgumentException.class, () ->
        device.corrector.track(0, at(0)));
    assertThrows(IllegalArgumentException.class, () ->
        device.corrector.track(MS, at(Double.NaN)));
    device.lock();
    DriftParameters none = new DriftParameters();
    none.lockViews = 0;
    assertThrows(IllegalArgumentException.class,
        () -> new DriftCorrector(none));
    DriftParameters sure = new DriftParameters();
    sure.minConfidence = 2;
    assertThrows(IllegalArgumentException.class,
        () -> new DriftCorrector(sure));
  }

  @Test
  public void onlySoManyGuessesAreKeptTheNewest() {
    DriftParameters parameters = new DriftParameters();
    parameters.maxHypotheses = 2;
    Device device = new Device(parameters);
    for (double x : new double[] {0, 20, 40}) {
      device.fix(at(x));
      device.step();
    }
    // The first was forgotten, the last was not.
    assertEquals(FixVerdict.HELD, device.fix(at(0)));
    device.step();
    assertEquals(FixVerdict.LOCKED, device.fix(at(40)));
  }

  @Test
  public void anErrorOfRotationBecomesOneOfPositionOnTheWay() {
    // 0.01 rad about z, 3 m along x: 3 cm along y.
    double[] moved = GaussianPose.transported(
        GaussianPose.diagonal(0, 1e-4), new Vector3(3, 0, 0));
    assertEquals(0, moved[0], 1e-15);
    assertEquals(9e-4, moved[7], 1e-12);
    assertEquals(9e-4, moved[14], 1e-12);
    assertEquals(3e-4, moved[11], 1e-12);
    assertEquals(-3e-4, moved[16], 1e-12);
  }

  @Test
  public void twoPosesAreOneByTheirInformation() {
    // 1 with variance 1 and 4 with variance 2: 2 with variance 2/3.
    GaussianPose a = new GaussianPose(at(1), GaussianPose.diagonal(1, 1));
    GaussianPose b = new GaussianPose(at(4), GaussianPose.diagonal(2, 1));
    GaussianPose both = a.fused(b);
    assertEquals(2, both.worldFromCamera.translationM.x, 1e-12);
    assertEquals(2.0 / 3, both.covariance[0], 1e-12);
    assertEquals(0.5, both.covariance[35], 1e-12);
    assertEquals(3, a.squaredDistance(b), 1e-12);
  }
}
