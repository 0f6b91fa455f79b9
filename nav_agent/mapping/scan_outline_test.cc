#include "nav_agent/mapping/scan_outline.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "common/geometry/rigid3.h"
#include "gtest/gtest.h"
#include "nav_agent/mapping/testing_plan.h"

namespace treeline::mapping {
namespace {

TEST(ScanOutline, PassesOverWhatIsNoReturn) {
  const core::RangeSensorInfo laser = TestLaser(10);
  std::vector<float> ranges_m(181, 2.0F);
  ranges_m[10] = core::kInvalidRange;
  ranges_m[20] = core::kNoReturn;
  ranges_m[30] = core::kTooNear;
  ranges_m[40] = 0.01F;
  ranges_m[50] = 11;
  const ScanOutline scan = MakeScanOutline(ranges_m, laser, {});
  EXPECT_EQ(scan.size(), 176u);
  for (const geometry::Vec2& point : scan.points_m)
    EXPECT_NEAR(geometry::Norm(point), 2, 1e-6);
  // A surface does not run over a gap.
  EXPECT_EQ(scan.joined[9], 0);
  EXPECT_EQ(scan.joined[8], 1);
}

TEST(ScanOutline, DropsWhatARobotThatLeansSeesOfTheFloor) {
  const core::RangeSensorInfo laser = TestLaser(10);
  const std::vector<float> ranges_m(181, 5.0F);
  // Nose down by 0.1 rad, the laser 0.35 m up: straight ahead the floor is met
  // at 3.5 m, to the sides it is not.
  const geometry::Rigid3 level_from_laser = {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0.1, 0}),
      .translation = {0, 0, 0.35}};
  const ScanOutline scan = MakeScanOutline(ranges_m, laser, level_from_laser,
                                           {.min_height_m = 0.05});
  EXPECT_LT(scan.size(), 120u);
  EXPECT_GT(scan.size(), 60u);
  for (const geometry::Vec2& point : scan.points_m) {
    EXPECT_LT(point.x, 3.1);
  }
}

// To keep the first return that is far enough from the last one kept prefers
// those whose noise took them on along the wall: both sides of a corridor then
// stand 0.6 mm to the right of where they are, which turns each scan a little.
TEST(ScanOutline, DoesNotLean) {
  constexpr int kScans = 100;
  const std::vector<TestWall> walls = {{{-60, -0.7}, {60, -0.7}},
                                       {{-60, 0.7}, {60, 0.7}}};
  core::RangeSensorInfo laser = TestLaser(25);
  laser.angle_increment_rad /= 4;
  laser.beams = 721;
  double sum_m = 0;
  int points = 0;
  for (uint64_t i = 0; i < kScans; ++i) {
    const ScanOutline scan =
        MakeScanOutline(CastScan(walls, {}, laser, 0.006, i), laser, {});
    for (const geometry::Vec2& point : scan.points_m) {
      if (point.x < 1 || point.x > 3) continue;
      sum_m += point.y - std::copysign(0.7, point.y);
      ++points;
    }
  }
  ASSERT_GT(points, 50 * kScans);
  EXPECT_NEAR(sum_m / points, 0, 1e-4);
}

}  // namespace
}  // namespace treeline::mapping
