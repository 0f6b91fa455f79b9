#include "nav_agent/core/slope_odometry.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::core {
namespace {

constexpr double kTrack_m = 0.54;

base::MonotonicTime At(int64_t milliseconds) {
  return base::MonotonicTime(std::chrono::milliseconds(milliseconds));
}

SlopeOdometry Make(const SlopeOdometryOptions& options = {}) {
  return *SlopeOdometry::Create(options);
}

// Readings of 10 ms: ahead at 0.5 m/s and turning.
struct Drive {
  SlopeOdometry odometry = Make();
  BaseReading reading;

  explicit Drive(const SlopeOdometryOptions& options = {})
      : odometry(Make(options)) {
    EXPECT_TRUE(odometry.Add(reading).ok());
  }
  void Go(int readings, double pitch_rad, double roll_rad, double turn_radps) {
    for (int i = 0; i < readings; ++i) {
      reading.stamp += std::chrono::milliseconds(10);
      reading.left_wheel_m += 0.01 * (0.5 - turn_radps * kTrack_m / 2);
      reading.right_wheel_m += 0.01 * (0.5 + turn_radps * kTrack_m / 2);
      reading.pitch_rad = pitch_rad;
      reading.roll_rad = roll_rad;
      reading.yaw_rate_radps = turn_radps;
      EXPECT_TRUE(odometry.Add(reading).ok());
    }
  }
};

TEST(SlopeOdometry, NoseUpClimbsAndShortensTheWayFromAbove) {
  Drive drive;
  drive.Go(1, -0.1, 0, 0);
  const geometry::Vec3 before = drive.odometry.OdomFromBase().translation;
  drive.Go(200, -0.1, 0, 0);
  const geometry::Vec3 after = drive.odometry.OdomFromBase().translation;
  EXPECT_NEAR(after.x - before.x, std::cos(0.1), 1e-9);
  EXPECT_NEAR(after.z - before.z, std::sin(0.1), 1e-9);
  EXPECT_NEAR(drive.odometry.way_m(), 1.005, 1e-9);
  // Down again.
  drive.Go(201, 0.1, 0, 0);
  EXPECT_NEAR(drive.odometry.height_m(), before.z, 0.005 * std::sin(0.1));
}

TEST(SlopeOdometry, ACircleOnAPlaneComesBackToItself) {
  // In the plane that is inclined by 0.2 about y, the robot turns once round:
  // pitch and roll follow from the heading in the plane.
  SlopeOdometryOptions options;
  options.level_within_rad = 0;
  Drive drive(options);
  const geometry::Rotation3 plane =
      geometry::Rotation3::FromAxisAngle({0, -0.2, 0});
  const double turn_radps = 0.5;
  const int steps =
      static_cast<int>(std::lround(2 * std::numbers::pi / turn_radps / 0.01));
  geometry::Vec3 highest;
  for (int i = 0; i <= steps; ++i) {
    const double angle = turn_radps * 0.01 * (i + 1);
    const geometry::Vec3 x =
        plane * geometry::Vec3{std::cos(angle), std::sin(angle), 0};
    const geometry::Vec3 y =
        plane * geometry::Vec3{-std::sin(angle), std::cos(angle), 0};
    const double pitch = -std::asin(x.z);
    const double roll = std::asin(y.z / std::cos(pitch));
    drive.Go(1, pitch, roll, turn_radps);
    const geometry::Vec3 here = drive.odometry.OdomFromBase().translation;
    if (here.z > highest.z) highest = here;
  }
  const geometry::Rigid3 end = drive.odometry.OdomFromBase();
  // Steps of 5 mm, the first of them on the level: 1 mm of 6.3 m.
  EXPECT_NEAR(end.translation.x, 0, 0.01);
  EXPECT_NEAR(end.translation.y, 0, 0.01);
  EXPECT_NEAR(end.translation.z, 0, 0.01);
  // Half way round and a quarter up: the highest point is a radius up the hill.
  EXPECT_NEAR(highest.z, std::sin(0.2), 0.02);
  EXPECT_NEAR(drive.odometry.PlanarOdomFromBase().yaw_rad, 0, 0.02);
}

TEST(SlopeOdometry, LevelFloorsStayLevelWhateverTheBias) {
  Drive drive;
  base::Random random(3, 0);
  for (int i = 0; i < 20000; ++i) {
    drive.Go(1, 0.006 + 0.002 * random.NextGaussian(),
             -0.005 + 0.002 * random.NextGaussian(), 0);
  }
  // 100 m; the bias alone would be 0.6 m of height.
  EXPECT_NEAR(drive.odometry.height_m(), 0, 1e-9);
  // And on a ramp it is known: 0.25 mrad of the mean of 2000 readings, and as
  // much of noise, on 10 m.
  const double before_m = drive.odometry.height_m();
  for (int i = 0; i < 2000; ++i) {
    drive.Go(1, -0.1 + 0.006 + 0.002 * random.NextGaussian(), -0.005, 0);
  }
  EXPECT_NEAR(drive.odometry.height_m() - before_m, 10 * std::sin(0.1), 0.005);
}

TEST(SlopeOdometry, SlippingWheelsDoNotTurnTheRobot) {
  Drive drive;
  for (int i = 0; i < 100; ++i) {
    drive.reading.stamp += std::chrono::milliseconds(10);
    drive.reading.left_wheel_m += 0.005;
    drive.reading.right_wheel_m += 0.007;
    ASSERT_TRUE(drive.odometry.Add(drive.reading).ok());
  }
  EXPECT_DOUBLE_EQ(drive.odometry.PlanarOdomFromBase().yaw_rad, 0);
  SlopeOdometryOptions options;
  options.uses_yaw_rate = false;
  Drive wheels(options);
  wheels.reading.stamp = At(100);
  wheels.reading.right_wheel_m = 0.054;
  ASSERT_TRUE(wheels.odometry.Add(wheels.reading).ok());
  EXPECT_NEAR(wheels.odometry.PlanarOdomFromBase().yaw_rad, 0.1, 1e-9);
}

TEST(SlopeOdometry, CountersThatJumpAreNoMotion) {
  Drive drive;
  drive.Go(100, 0, 0, 0);
  drive.reading.left_wheel_m = 0;
  drive.reading.right_wheel_m = 0;
  drive.Go(1, 0, 0, 0);
  EXPECT_EQ(drive.odometry.resets(), 1);
  drive.Go(100, 0, 0, 0);
  EXPECT_NEAR(drive.odometry.PlanarOdomFromBase().translation.x, 1.0, 1e-9);
}

TEST(SlopeOdometry, BadReadingsAreNamedAndChangeNothing) {
  Drive drive;
  drive.Go(10, 0, 0, 0);
  const geometry::Rigid3 before = drive.odometry.OdomFromBase();
  BaseReading bad = drive.reading;
  bad.pitch_rad = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(drive.odometry.Add(bad).code(), absl::StatusCode::kInvalidArgument);
  bad = drive.reading;
  bad.roll_rad = 1.4;
  EXPECT_EQ(drive.odometry.Add(bad).code(), absl::StatusCode::kInvalidArgument);
  bad = drive.reading;
  bad.stamp = At(20);
  EXPECT_EQ(drive.odometry.Add(bad).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(drive.odometry.OdomFromBase(), before);
  drive.Go(10, 0, 0, 0);
  EXPECT_NEAR(drive.odometry.PlanarOdomFromBase().translation.x, 0.1, 1e-9);

  SlopeOdometryOptions options;
  options.wheel_track_m = 0;
  EXPECT_FALSE(SlopeOdometry::Create(options).ok());
}

}  // namespace
}  // namespace treeline::core
