#include "nav_agent/mapping/traversed_ground.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/mapping/scan_plane.h"

namespace treeline::mapping {
namespace {

// Up a ramp of 1:8, to a floor above.
TraversedGround Ramp() {
  TraversedGround ground(0.6);
  for (int i = 0; i <= 40; ++i) {
    const double x_m = 0.2 * i;
    ground.Add({x_m, 0, x_m / 8});
  }
  return ground;
}

TEST(TraversedGround, KnowsHowHighItIsWhereTheRobotDrove) {
  const TraversedGround ground = Ramp();
  EXPECT_FALSE(ground.IsLevel(0.12));
  EXPECT_TRUE(ground.IsNear({4, 0.3, 0.5}, 0.12));
  EXPECT_TRUE(ground.IsNear({4, 0.3, 0.6}, 0.12));
  EXPECT_FALSE(ground.IsNear({4, 0.3, 0.85}, 0.12));
  EXPECT_FALSE(ground.IsNear({4, 0.8, 0.5}, 0.12));
  EXPECT_FALSE(ground.IsNear({-3, 0, 0}, 0.12));
  EXPECT_TRUE(TraversedGround(0.6).IsLevel(0.1));
}

TEST(TraversedGround, TakesOutBeamsThatEndOnIt) {
  // Three beams of a level laser 0.35 m above the foot of the ramp: ahead onto
  // the ramp, where it is as high, and to walls at both sides.
  const core::RangeSensorInfo laser = {
      .angle_min_rad = -std::numbers::pi / 2,
      .angle_increment_rad = std::numbers::pi / 2,
      .beams = 3,
      .range_min_m = 0.02,
      .range_max_m = 30,
      .beam_interval_s = 0,
      .scan_interval_s = 0};
  const std::vector<float> kept = WithoutGround(
      std::vector<float>{0.5F, 2.8F, core::kNoReturn}, laser,
      {.rotation = {}, .translation = {0, 0, 0.35}}, Ramp(), 0.12);
  EXPECT_EQ(kept[0], 0.5F);
  EXPECT_TRUE(std::isnan(kept[1]));
  EXPECT_EQ(kept[2], core::kNoReturn);
}

TEST(ScanPlane, IsTheSameAlongARampAndAnotherOnTheFloorAbove) {
  const geometry::Vec2 up = {0.125, 0};
  const ScanPlane low = {.at = {1, 0}, .height_m = 0.125, .slope = up};
  const ScanPlane high = {.at = {7, 0}, .height_m = 0.875, .slope = up};
  EXPECT_NEAR(Gap_m(low, high), 0, 1e-12);
  EXPECT_NEAR(ClimbBySlope_m(low, high), 0.75, 1e-12);
  EXPECT_EQ(TiltBetween(low, high), 0);
  const ScanPlane floor = {.at = {1, 0}, .height_m = 0.125, .slope = {}};
  EXPECT_NEAR(TiltBetween(low, floor), 0.125, 1e-12);
  const ScanPlane storey = {.at = {1, 0.5}, .height_m = 2.7, .slope = {}};
  EXPECT_NEAR(Gap_m(floor, storey), 2.575, 1e-12);
}

TEST(ScanPlane, NoseUpClimbsAhead) {
  const geometry::Vec2 slope =
      SlopeUnder(geometry::Rotation3::FromAxisAngle({0, -0.1, 0}));
  EXPECT_NEAR(slope.x, std::tan(0.1), 1e-12);
  EXPECT_NEAR(slope.y, 0, 1e-12);
  // The left side up.
  const geometry::Vec2 across =
      SlopeUnder(geometry::Rotation3::FromAxisAngle({0.1, 0, 0}));
  EXPECT_NEAR(across.y, std::tan(0.1), 1e-12);
  EXPECT_EQ(SlopeUnder({}), geometry::Vec2{});
}

}  // namespace
}  // namespace treeline::mapping
