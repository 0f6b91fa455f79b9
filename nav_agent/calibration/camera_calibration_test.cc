#include "nav_agent/calibration/camera_calibration.h"

#include <cmath>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::calibration {
namespace {

constexpr double kDelay_s = 0.05;

geometry::Rigid3 Mount() {
  // 0.2 rad to the left, 0.3 down, 0.05 about its axis.
  return {geometry::Rotation3::FromAxisAngle({0, 0, 0.2}) *
              core::RobotModel::UprightCamera({}, 0.3).rotation *
              geometry::Rotation3::FromAxisAngle({0, 0, 0.05}),
          {0.15, -0.06, 1.0}};
}

struct Recorded {
  Drive drive;
  std::vector<CameraView> views;
};

// Straight, left, straight, right and so on; pictures ten times a second, off
// by 2 mm and 1 mrad each.
Recorded Record(bool turns, uint64_t seed) {
  Recorded recorded;
  recorded.drive.longest_gap_s = 1;
  base::Random random(seed, 1);
  geometry::Rigid2 pose;
  double left_m = 0;
  double right_m = 0;
  const double track_m = 0.54;
  for (int i = 0; i < 12000; ++i) {
    const double time_s = 0.01 * i;
    const int phase = (i / 200) % 4;
    const double forward_mps = phase % 2 == 0 ? 0.5 : 0.1;
    const double turn_radps = !turns || phase % 2 == 0 ? 0
                              : phase == 1             ? 0.8
                                                       : -0.7;
    pose = pose * geometry::Rigid2{{forward_mps * 0.01, 0}, turn_radps * 0.01};
    left_m += 0.01 * (forward_mps - turn_radps * track_m / 2);
    right_m += 0.01 * (forward_mps + turn_radps * track_m / 2);
    recorded.drive.readings.push_back({time_s, left_m, right_m, turn_radps});
    if (i % 10 != 0) continue;
    const auto noise = [&](double sigma) {
      return geometry::Vec3{sigma * random.NextGaussian(),
                            sigma * random.NextGaussian(),
                            sigma * random.NextGaussian()};
    };
    const geometry::Rigid3 base = {
        geometry::Rotation3::FromAxisAngle({0, 0, pose.yaw_rad}),
        {pose.translation.x, pose.translation.y, 0}};
    recorded.views.push_back(
        {time_s + kDelay_s,
         base * Mount() *
             geometry::Rigid3{geometry::Rotation3::FromAxisAngle(noise(0.001)),
                              noise(0.002)}});
  }
  return recorded;
}

const Setup kSetup = {.wheels = {.track_m = 0.54}, .base_from_laser = {}};

TEST(CameraCalibration, FindsTheCameraWithinWhatItStates) {
  for (const uint64_t seed : {1u, 2u}) {
    const Recorded recorded = Record(true, seed);
    std::vector<double> heights_m;
    for (int i = 0; i < 30; ++i) heights_m.push_back(1.0 + 0.001 * (i % 5 - 2));
    const auto found =
        CalibrateCamera(recorded.drive, kSetup, recorded.views, heights_m,
                        core::RobotModel::UprightCamera({0.1, 0, 1.1}, 0.2));
    ASSERT_TRUE(found.ok()) << found.status();
    const double truth[] = {0.15, -0.06, 1.0, 0.2, 0.3, 0.05, kDelay_s};
    for (int i = 0; i < kCameraQuantities; ++i) {
      const auto quantity = static_cast<CameraQuantity>(i);
      const Estimate& estimate = found->Of(quantity);
      EXPECT_TRUE(estimate.is_known) << NameOf(quantity);
      EXPECT_NEAR(estimate.value, truth[i], 3 * estimate.sigma)
          << NameOf(quantity);
    }
    EXPECT_LT(found->after.rms_m, 0.2 * found->before.rms_m);
    const geometry::Rigid3 off = Mount().Inverse() * found->BaseFromCamera();
    EXPECT_LT(geometry::Norm(off.translation), 0.02);
  }
}

TEST(CameraCalibration, SaysWhatAStraightDriveDoesNotShow) {
  const Recorded recorded = Record(false, 3);
  const auto found =
      CalibrateCamera(recorded.drive, kSetup, recorded.views, {},
                      core::RobotModel::UprightCamera({0.1, 0, 1.1}, 0.2));
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_FALSE(found->Of(CameraQuantity::kX).is_known);
  EXPECT_FALSE(found->Of(CameraQuantity::kY).is_known);
  EXPECT_FALSE(found->Of(CameraQuantity::kZ).is_known);
  EXPECT_EQ(found->Of(CameraQuantity::kZ).value, 1.1);
  EXPECT_FALSE(CalibrateCamera(recorded.drive, kSetup, {}, {}, {}).ok());
}

// A camera 1 m above a floor, 0.4 rad down: rays of the lower half meet it.
TEST(CameraCalibration, SeesTheFloor) {
  camera::RgbdCalibration calibration;
  calibration.color = *camera::Camera::Parse("PINHOLE,100,100,80,60", 160, 120);
  calibration.depth = calibration.color;
  const geometry::Rotation3 base_from_camera =
      core::RobotModel::UprightCamera({}, 0.4).rotation;
  image::DepthImage depth{.width = 160, .height = 120, .values = {}};
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const geometry::Vec3 ray = {(u - 80) / 100.0, (v - 60) / 100.0, 1};
      const double falls = -(base_from_camera * ray).z;
      const double depth_m = falls > 0 ? 1.0 / falls : 0;
      depth.values.push_back(
          depth_m > 0 && depth_m < 6
              ? static_cast<uint16_t>(std::lround(1000 * depth_m))
              : 0);
    }
  }
  const auto below_m = FloorBelow_m(depth, calibration, base_from_camera);
  ASSERT_TRUE(below_m.has_value());
  EXPECT_NEAR(*below_m, 1.0, 0.002);
  depth.values.assign(depth.values.size(), 0);
  EXPECT_FALSE(FloorBelow_m(depth, calibration, base_from_camera).has_value());
}

}  // namespace
}  // namespace treeline::calibration
