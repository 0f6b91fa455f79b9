#include "nav_agent/calibration/wheel_path.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::calibration {
namespace {

// Half a turn on the spot in 1 s, then a metre ahead in 1 s.
std::vector<DriveReading> Readings() {
  const double half_turn_m = 0.5 * 0.5 * M_PI;
  std::vector<DriveReading> readings;
  for (int i = 0; i <= 10; ++i) {
    readings.push_back(
        {0.1 * i, -0.1 * i * half_turn_m, 0.1 * i * half_turn_m, M_PI});
  }
  for (int i = 1; i <= 10; ++i) {
    readings.push_back(
        {1 + 0.1 * i, -half_turn_m + 0.1 * i, half_turn_m + 0.1 * i, 0});
  }
  return readings;
}

TEST(WheelPath, FollowsWheelsAsTheyAre) {
  const std::vector<DriveReading> readings = Readings();
  const WheelPath path(readings, 1);
  const Wheels wheels = {.track_m = 0.5};
  const auto motion = path.Motion(0, 2, wheels);
  ASSERT_TRUE(motion.has_value());
  EXPECT_NEAR(motion->translation.x, -1, 1e-9);
  EXPECT_NEAR(motion->translation.y, 0, 1e-9);
  EXPECT_NEAR(std::abs(motion->yaw_rad), M_PI, 1e-9);
  // Twice the track, half the turn.
  EXPECT_NEAR(path.Motion(0, 1, {.track_m = 1})->yaw_rad, M_PI / 2, 1e-9);
  EXPECT_NEAR(path.Motion(1, 2, {1.1, 1.1, 0.5})->translation.x, 1.1, 1e-9);
  // In between.
  EXPECT_NEAR(path.Motion(1.25, 1.75, wheels)->translation.x, 0.5, 1e-9);
  EXPECT_NEAR(path.Way_m(1.25, 1.75), 0.5, 1e-9);
  EXPECT_NEAR(*path.GyroscopeTurn_rad(0.25, 0.75), M_PI / 2, 1e-9);
}

TEST(WheelPath, KnowsNothingBeyondReadingsGapsAndResets) {
  std::vector<DriveReading> readings = Readings();
  readings.push_back({5, readings.back().left_m, readings.back().right_m, 0});
  readings.push_back({5.1, 0, 0, 0});
  readings.push_back({5.2, 0.05, 0.05, 0});
  const WheelPath path(readings, 1);
  const Wheels wheels;
  EXPECT_FALSE(path.Motion(-0.1, 1, wheels).has_value());
  EXPECT_FALSE(path.Motion(1, 9, wheels).has_value());
  EXPECT_FALSE(path.Motion(1.5, 5, wheels).has_value());
  EXPECT_FALSE(path.Motion(5, 5.2, wheels).has_value());
  EXPECT_TRUE(path.Motion(5.1, 5.2, wheels).has_value());
  EXPECT_FALSE(WheelPath({}, 1).Motion(0, 0, wheels).has_value());
  EXPECT_EQ(WheelPath({}, 1).Way_m(0, 1), 0);
}

}  // namespace
}  // namespace treeline::calibration
