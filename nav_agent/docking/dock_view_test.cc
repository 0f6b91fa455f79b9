#include "nav_agent/docking/dock_view.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/docking/parameters.h"
#include "nav_agent/docking/testing_dock_room.h"

namespace treeline::docking {
namespace {

// The noise is 1 cm a beam, some hundred beams say where it is.
constexpr double kExact_m = 0.008;
constexpr double kExact_rad = 0.008;

Dock Looked(DockRoom& room) {
  Dock dock = DockRoom::Charger();
  DockViewMaker maker(room.robot);
  while (!maker.IsDone()) maker.Add(room.Scan(dock.map_from_docked));
  dock.view = maker.View();
  return dock;
}

// A robot at `truth` that believes to be elsewhere by `off`: where it sees the
// dock to be, less where that is in truth, both from itself.
void ExpectSeen(DockRoom& room, const Dock& dock, const geometry::Rigid2& truth,
                const geometry::Rigid2& off,
                const geometry::Rigid2& true_docked) {
  const geometry::Rigid2 believed = truth * off;
  const auto seen =
      FindDock(dock, DockRoom::Placed(believed, room.Scan(truth)), room.robot);
  ASSERT_TRUE(seen.has_value());
  const geometry::Rigid2 by_sight = believed.Inverse() * seen->map_from_docked;
  const geometry::Rigid2 in_truth = truth.Inverse() * true_docked;
  EXPECT_NEAR(by_sight.translation.x, in_truth.translation.x, kExact_m);
  EXPECT_NEAR(by_sight.translation.y, in_truth.translation.y, kExact_m);
  EXPECT_NEAR(by_sight.yaw_rad, in_truth.yaw_rad, kExact_rad);
}

TEST(DockView, IsTheMedianOfManyScans) {
  DockRoom room;
  const Dock dock = Looked(room);
  ASSERT_GT(dock.view.size(), 400u);
  int near = 0;
  for (const geometry::Vec2& point : dock.view) {
    // The body's front, between its corners.
    if (point.x > 0.36 || std::abs(point.y) > 0.09) continue;
    if (std::hypot(point.x - 0.22, point.y) > 0.2) continue;
    ++near;
    // Of 20 scans, 2.8 mm: three and a half of that.
    EXPECT_NEAR(point.x, 0.32, 0.01);
  }
  EXPECT_GT(near, 30);
}

TEST(DockView, WhoWasCarriedSeesThatAndWhoIsCrowdedDoesNot) {
  DockRoom room;
  const Dock dock = Looked(room);
  const geometry::Rigid2 docked = dock.map_from_docked;
  EXPECT_FALSE(IsElsewhere(dock, room.Scan(docked), room.robot));
  for (const geometry::Rigid2& elsewhere :
       {geometry::Rigid2{{1, 1.5}, 0}, geometry::Rigid2{{3, 1.5}, 1.6},
        geometry::Rigid2{{2, 2.2}, 3.1}}) {
    EXPECT_TRUE(IsElsewhere(dock, room.Scan(elsewhere), room.robot))
        << elsewhere.translation.x;
  }
  // Three people hide most of the room.
  DockRoom crowded;
  crowded.AddBox({2.2, 1.5}, 0.15, 0.4);
  crowded.AddBox({3, 0.8}, 0.4, 0.15);
  crowded.AddBox({3, 2.2}, 0.4, 0.15);
  EXPECT_FALSE(IsElsewhere(dock, crowded.Scan(docked), room.robot));
  EXPECT_FALSE(
      IsElsewhere(DockRoom::Charger(), room.Scan({{1, 1.5}, 0}), room.robot));
}

TEST(DockView, WhoWalksPastIsNotInIt) {
  DockRoom empty;
  DockViewMaker maker(empty.robot);
  const geometry::Rigid2 docked = DockRoom::Charger().map_from_docked;
  for (int i = 0; !maker.IsDone(); ++i) {
    DockRoom room;
    room.AddBox({2.2, 0.6 + 0.05 * i}, 0.15, 0.15);
    maker.Add(room.Scan(docked));
  }
  for (const geometry::Vec2& point : maker.View()) {
    const geometry::Vec2 in_room = docked * point;
    EXPECT_FALSE(std::abs(in_room.x - 2.2) < 0.14 &&
                 std::abs(in_room.y - 1.5) < 0.7);
  }
}

TEST(DockView, TellsWhereTheDockIsFromTheStagingPoseOn) {
  DockRoom room;
  const Dock dock = Looked(room);
  for (const double back_m : {0.85, 0.6, 0.3, 0.1, 0.0}) {
    for (const double side : {-1.0, 1.0}) {
      SCOPED_TRACE(back_m);
      const geometry::Rigid2 truth =
          dock.map_from_docked *
          geometry::Rigid2{{-back_m, side * 0.06}, -side * 0.05};
      ExpectSeen(room, dock, truth, {{0.05, side * 0.06}, side * 0.06},
                 dock.map_from_docked);
    }
  }
}

TEST(DockView, ABodyThatWasMovedIsFollowed) {
  DockRoom room;
  const Dock dock = Looked(room);
  for (const geometry::Vec2 by :
       {geometry::Vec2{0.05, 0}, geometry::Vec2{-0.05, 0},
        geometry::Vec2{0, 0.05}, geometry::Vec2{0, -0.05}}) {
    room.PutDock(by);
    geometry::Rigid2 moved = dock.map_from_docked;
    moved.translation = moved.translation + by;
    for (const double back_m : {0.4, 0.2, 0.06}) {
      const geometry::Rigid2 truth = moved * geometry::Rigid2{{-back_m, 0}, 0};
      const auto seen =
          FindDock(dock, DockRoom::Placed(truth, room.Scan(truth)), room.robot);
      ASSERT_TRUE(seen.has_value());
      // It has drawn the match of all that stands around a little after it.
      EXPECT_NEAR(seen->moved_m, 0.05, 0.02) << back_m;
      // Its front is 20 cm wide: noise on both ends of that.
      EXPECT_NEAR(seen->map_from_docked.translation.x, moved.translation.x,
                  0.01);
      EXPECT_NEAR(seen->map_from_docked.translation.y, moved.translation.y,
                  0.012);
    }
  }
}

TEST(DockView, ThingsThatCameSinceAreLookedPast) {
  DockRoom room;
  const Dock dock = Looked(room);
  room.AddBox({1.6, 2.6}, 0.3, 0.2);
  room.AddBox({2.6, 0.6}, 0.2, 0.2);
  const geometry::Rigid2 truth =
      dock.map_from_docked * geometry::Rigid2{{-0.5, 0.02}, 0.02};
  ExpectSeen(room, dock, truth, {{0.04, -0.03}, -0.03}, dock.map_from_docked);
}

TEST(DockView, WhatIsSomewhereElseIsNoDock) {
  DockRoom room;
  const Dock dock = Looked(room);
  EXPECT_TRUE(PlaceInDock(dock, room.Scan(dock.map_from_docked)).has_value());
  EXPECT_FALSE(PlaceInDock(dock, room.Scan({{1.8, 1}, 1})).has_value());
  EXPECT_FALSE(PlaceInDock(dock, {}).has_value());
  EXPECT_FALSE(PlaceInDock(DockRoom::Charger(), room.Scan(dock.map_from_docked))
                   .has_value());
  const geometry::Rigid2 beside =
      dock.map_from_docked * geometry::Rigid2{{-0.05, 0.04}, 0.05};
  const auto place = PlaceInDock(dock, room.Scan(beside));
  ASSERT_TRUE(place.has_value());
  EXPECT_NEAR(place->translation.x, beside.translation.x, kExact_m);
  EXPECT_NEAR(place->translation.y, beside.translation.y, kExact_m);
  EXPECT_NEAR(place->yaw_rad, beside.yaw_rad, kExact_rad);
}

}  // namespace
}  // namespace treeline::docking
