#include "nav_agent/mapping/scan_agreement.h"

#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/mapping/testing_plan.h"

namespace treeline::mapping {
namespace {

constexpr double kNoise_m = 0.015;

// A corridor of 2 m with a door recess on one side and a cupboard on the other.
std::vector<TestWall> Corridor() {
  std::vector<TestWall> walls = {{{-20, -1}, {3, -1}}, {{4, -1}, {20, -1}},
                                 {{3, -1}, {3, -3}},   {{3, -3}, {4, -3}},
                                 {{4, -3}, {4, -1}},   {{-20, 1}, {20, 1}}};
  AddBox({5, 0.4}, {5.8, 1}, &walls);
  return walls;
}

ScanOutline SeenAt(const std::vector<TestWall>& walls,
                   const geometry::Rigid2& map_from_base,
                   const geometry::Rigid3& base_from_laser = {}) {
  const core::RangeSensorInfo laser = TestLaser(15);
  const geometry::Vec3& mount = base_from_laser.translation;
  const geometry::Rigid2 map_from_laser = {
      map_from_base * geometry::Vec2{mount.x, mount.y}, map_from_base.yaw_rad};
  return MakeScanOutline(CastScan(walls, map_from_laser, laser, kNoise_m, 1),
                         laser, base_from_laser);
}

TEST(SeenSpace, ScansOfOnePlaceDoNotContradictEachOther) {
  const geometry::Rigid2 map_from_a = {{0, 0}, 0.1};
  const geometry::Rigid2 map_from_b = {{1.2, 0.3}, -0.2};
  const ScanOutline a = SeenAt(Corridor(), map_from_a);
  const ScanOutline b = SeenAt(Corridor(), map_from_b);
  // Poses that are off by as much as maps are while a loop is open do no harm.
  const geometry::Rigid2 off = {{0.1, -0.05}, 0.01};
  const geometry::Rigid2 a_from_b = map_from_a.Inverse() * map_from_b * off;
  const Contradictions told = SeenSpace(a).Contradicted(b, a_from_b);
  EXPECT_GT(told.told, 50);
  EXPECT_LT(told.Share(), 0.01);
}

TEST(SeenSpace, WallsWhereAnotherScanLookedThroughAreContradicted) {
  const geometry::Rigid2 map_from_a = {{0, 0}, 0};
  const ScanOutline a = SeenAt(Corridor(), map_from_a);
  const ScanOutline b = SeenAt(Corridor(), {{2, 0}, 0});
  // Two metres along the corridor: the cupboard stands in the way.
  const Contradictions told = SeenSpace(a).Contradicted(b, map_from_a);
  EXPECT_GT(told.contradicted, 3);
  // Turned, the walls do.
  EXPECT_GT(SeenSpace(a).Contradicted(b, {{2, 0}, 0.3}).Share(), 0.04);
}

TEST(SeenSpace, WhatWasNotSeenIsNotTold) {
  // Behind the robot, beyond walls, and of a scan without returns.
  const ScanOutline a = SeenAt(Corridor(), {{0, 0}, 0});
  ScanOutline behind;
  behind.points_m = {{-2, 0}, {-1, 0.5}, {2, 3}, {2, -2}};
  behind.joined = {0, 0, 0, 0};
  EXPECT_EQ(SeenSpace(a).Contradicted(behind, {}).told, 0);
  EXPECT_EQ(SeenSpace(ScanOutline{}).Contradicted(a, {}).told, 0);
  EXPECT_EQ(SeenSpace(a).Contradicted(ScanOutline{}, {}).Share(), 0);
}

TEST(SeenSpace, LooksFromWhereTheLaserIs) {
  const geometry::Rigid3 base_from_laser = {.rotation = {},
                                            .translation = {0.5, 0.3, 0}};
  const ScanOutline mounted = SeenAt(Corridor(), {}, base_from_laser);
  EXPECT_EQ(mounted.seen_from, (geometry::Vec2{0.5, 0.3}));
  const ScanOutline other = SeenAt(Corridor(), {{1, 0}, 0});
  const Contradictions told =
      SeenSpace(mounted).Contradicted(other, {{1, 0}, 0});
  EXPECT_GT(told.told, 50);
  EXPECT_LT(told.Share(), 0.01);
}

}  // namespace
}  // namespace treeline::mapping
