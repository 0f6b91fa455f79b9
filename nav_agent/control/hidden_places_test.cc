#include "nav_agent/control/hidden_places.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::control {
namespace {

constexpr double kInterval_s = 0.025;
constexpr uint32_t kAll = ~uint32_t{0};

// Nobody walks faster than 1 m/s; cells of 0.1 m, 6 x 6 m.
HiddenPlacesOptions Options() {
  return {.size_m = 6, .resolution_m = 0.1, .spread_mps = 1};
}

void SpreadFor(double seconds, HiddenPlaces& places,
               const HiddenPlaces::IsSolid& is_solid = nullptr) {
  const auto steps = std::lround(seconds / kInterval_s);
  for (long step = 0; step < steps; ++step)
    places.Spread({0, 0}, kInterval_s, is_solid);
}

TEST(HiddenPlaces, AreWhereOneCanHaveWalkedTo) {
  HiddenPlaces places(Options());
  const int who = *places.Take();
  places.Put(who, {0, 0}, 0.5);
  SpreadFor(1, places);
  // A disc of 1.5 m; sets grow as an octagon, cell by cell.
  double farthest_m = 0;
  for (const geometry::Vec2& at : places.PlacesOf(kAll))
    farthest_m = std::max(farthest_m, geometry::Norm(at));
  EXPECT_NEAR(farthest_m, 1.5, 0.15);
  EXPECT_NEAR(places.Area_m2(who), std::numbers::pi * 1.5 * 1.5, 0.8);
  EXPECT_TRUE(places.MayBeNear(who, {1.6, 0}, 0.3));
  EXPECT_FALSE(places.MayBeNear(who, {2.0, 0}, 0.3));
}

TEST(HiddenPlaces, EndAtWalls) {
  HiddenPlaces places(Options());
  const int who = *places.Take();
  places.Put(who, {0, 0}, 0.3);
  SpreadFor(2, places, [](geometry::Vec2 at) {
    return std::abs(at.x) > 0.5 && std::abs(at.x) < 0.65;
  });
  ASSERT_GT(places.Area_m2(who), 2);
  for (const geometry::Vec2& at : places.PlacesOf(kAll))
    EXPECT_LT(std::abs(at.x), 0.5);
}

TEST(HiddenPlaces, AreNotWhereALaserLooksThrough) {
  HiddenPlaces places(Options());
  const int who = *places.Take();
  places.Put(who, {0, 0}, 1.0);
  // It looks along x, half a turn wide; ahead it ends at 0.5 m.
  const core::RangeSensorInfo laser = {
      .angle_min_rad = -std::numbers::pi / 2,
      .angle_increment_rad = std::numbers::pi / 180,
      .beams = 181,
      .range_min_m = 0.01,
      .range_max_m = 30,
      .beam_interval_s = 0,
      .scan_interval_s = kInterval_s};
  core::LaserScan scan;
  scan.ranges_m.assign(181, core::kNoReturn);
  for (size_t beam = 70; beam <= 110; ++beam) scan.ranges_m[beam] = 0.5F;
  const TrackedScan look = {
      .laser = laser, .map_from_laser = {}, .scan = scan, .points = {}};
  places.LookThrough({&look, 1});
  EXPECT_TRUE(places.MayBeNear(who, {-0.5, 0}, 0.1));
  EXPECT_TRUE(places.MayBeNear(who, {0.8, 0}, 0.1));
  EXPECT_FALSE(places.MayBeNear(who, {0.3, 0}, 0.1));
  EXPECT_FALSE(places.MayBeNear(who, {0.1, 0.7}, 0.1));
}

TEST(HiddenPlaces, StayInTheMapWhenTheRobotMoves) {
  HiddenPlaces places(Options());
  const int who = *places.Take();
  places.Put(who, {1, 1}, 0.3);
  const double before_m2 = places.Area_m2(who);
  places.Spread({1.5, -0.5}, 0, nullptr);
  EXPECT_EQ(places.Area_m2(who), before_m2);
  EXPECT_TRUE(places.MayBeNear(who, {1, 1}, 0.1));
  // Who is left behind, beyond the square, is not there any more.
  places.Spread({9, -0.5}, 0, nullptr);
  EXPECT_EQ(places.Area_m2(who), 0);
}

TEST(HiddenPlaces, OfOneAreNotThoseOfAnother) {
  HiddenPlaces places(Options());
  const int one = *places.Take();
  const int other = *places.Take();
  places.Put(one, {1, 0}, 0.3);
  places.Put(other, {-1, 0}, 0.3);
  EXPECT_FALSE(places.MayBeNear(one, {-1, 0}, 0.3));
  places.Give(one);
  EXPECT_EQ(places.Area_m2(one), 0);
  EXPECT_GT(places.Area_m2(other), 0);
  EXPECT_EQ(*places.Take(), one);
}

TEST(HiddenPlaces, HaveRoomForThirtyTwo) {
  HiddenPlaces places(Options());
  for (int i = 0; i < 32; ++i) EXPECT_TRUE(places.Take().has_value());
  EXPECT_FALSE(places.Take().has_value());
}

}  // namespace
}  // namespace treeline::control
