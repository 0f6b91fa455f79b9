#include "nav_agent/mapless/way_field.h"

#include <algorithm>
#include <cmath>

#include "gtest/gtest.h"
#include "nav_agent/mapless/testing_clutter.h"

namespace treeline::mapless {
namespace {

constexpr geometry::Vec2 kRobot = {0, 0};
constexpr geometry::Vec2 kGoal = {6, 0};

WayField Field() { return WayField(BodyShape(SmallRobot(), kBodyMargin_m)); }

// The side of x = 3 on which a way passes it.
double SideAt3(const WayField& way) {
  for (const geometry::Vec2 point : way.path()) {
    if (point.x >= 3) return point.y;
  }
  return NAN;
}

TEST(WayField, WhatWasNeverSeenIsFree) {
  EvidenceGrid map;
  WayField way = Field();
  ASSERT_TRUE(way.Update(map, kRobot, kGoal));
  EXPECT_NEAR(way.length_m(), 6, 0.1);
  EXPECT_NEAR(way.ToGo(kRobot), 6, 0.1);
  EXPECT_NEAR(way.ToGo({3, 0}), 3, 0.1);
}

TEST(WayField, LeadsAroundWhatStandsInTheWay) {
  EvidenceGrid map;
  AddWall({3, -1}, {3, 2}, map);
  WayField way = Field();
  ASSERT_TRUE(way.Update(map, kRobot, kGoal));
  // Around the nearer end, by more than the body's half width.
  EXPECT_LT(SideAt3(way), -1.2);
  EXPECT_GT(way.ToGo(kRobot), 6.3);
  // Where the body does not fit it is not told, or dear.
  EXPECT_GT(way.ToGo({3, 0.5}), way.ToGo(kRobot));
}

TEST(WayField, AGapThatTheBodyDoesNotFitThroughIsNone) {
  EvidenceGrid map;
  AddWall({3, -3}, {3, -0.2}, map);
  AddWall({3, 0.2}, {3, 3}, map);
  WayField way = Field();
  ASSERT_TRUE(way.Update(map, kRobot, kGoal));
  EXPECT_GT(std::abs(SideAt3(way)), 3);
}

TEST(WayField, KeepsTheWayItHasUnlessAnotherIsClearlyBetter) {
  EvidenceGrid map;
  // Both ends are about as near.
  AddWall({3, -1}, {3, 1.05}, map);
  WayField way = Field();
  ASSERT_TRUE(way.Update(map, kRobot, kGoal));
  ASSERT_LT(SideAt3(way), 0);
  // The way it takes turns out a little longer: a fresh field would change.
  AddWall({3, -1.25}, {3, -1}, map);
  WayField fresh = Field();
  ASSERT_TRUE(fresh.Update(map, kRobot, kGoal));
  EXPECT_GT(SideAt3(fresh), 0);
  ASSERT_TRUE(way.Update(map, kRobot, kGoal));
  EXPECT_LT(SideAt3(way), 0);
  EXPECT_EQ(way.changes(), 0);
  // Blocked: now it changes.
  AddWall({3, -8}, {3, -1}, map);
  ASSERT_TRUE(way.Update(map, kRobot, kGoal));
  EXPECT_GT(SideAt3(way), 0);
  EXPECT_EQ(way.changes(), 1);
}

TEST(WayField, SaysWhereThereIsNoWay) {
  EvidenceGrid map;
  AddWall({-1, -1}, {1, -1}, map);
  AddWall({1, -1}, {1, 1}, map);
  AddWall({1, 1}, {-1, 1}, map);
  AddWall({-1, 1}, {-1, -1}, map);
  WayField way = Field();
  EXPECT_FALSE(way.Update(map, kRobot, kGoal));
  EXPECT_TRUE(way.path().empty());
}

TEST(WayField, AGoalWithoutRoomIsMovedToWhereThereIs) {
  EvidenceGrid map;
  AddWall({5.8, -0.5}, {5.8, 0.5}, map);
  WayField way = Field();
  ASSERT_TRUE(way.Update(map, kRobot, {5.8, 0}));
  EXPECT_GT(way.moved_goal_m(), 0.15);
  EXPECT_LT(way.moved_goal_m(), 0.4);
}

TEST(WayField, ARobotThatStandsTooNearIsLedOut) {
  EvidenceGrid map;
  AddWall({-0.5, 0.19}, {0.5, 0.19}, map);
  WayField way = Field();
  EXPECT_TRUE(way.Update(map, kRobot, kGoal));
  EXPECT_GT(way.ToGo(kRobot), way.ToGo({0, -0.3}));
}

}  // namespace
}  // namespace treeline::mapless
