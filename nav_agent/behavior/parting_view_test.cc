#include "nav_agent/behavior/parting_view.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "gtest/gtest.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {
namespace {

constexpr double kRadius_m = 0.36;

// A hall of 20 by 8 m, floor at height_m.
traversability::TraversableLevel Hall(double height_m) {
  traversability::TraversableLevel level;
  level.grid =
      core::OccupancyGrid::Filled(400, 160, 0.05, {}, core::Occupancy::kFree);
  for (int y = 0; y < 160; ++y) {
    for (int x = 0; x < 400; ++x) {
      if (x < 2 || y < 2 || x >= 398 || y >= 158) {
        level.grid.Set({x, y}, core::Occupancy::kOccupied);
      }
    }
  }
  level.height_m.assign(level.grid.cells.size(),
                        static_cast<float>(height_m - 0.025));
  level.slope_rad.assign(level.grid.cells.size(), 0);
  level.clearance_m.assign(level.grid.cells.size(), 2.5f);
  return level;
}

traversability::NavigationMap MapOf(
    std::vector<traversability::TraversableLevel> levels) {
  return *traversability::NavigationMap::Make(
      {.levels = std::move(levels), .joins = {}});
}

core::LevelPose PoseIn(geometry::Vec2 at, double yaw_rad, int level = 0,
                       double height_m = 0) {
  return {.map_from_base = {at, yaw_rad},
          .place = {.level = level, .height_m = height_m}};
}

class PartingViewTest : public testing::Test {
 protected:
  PartingViewTest() {
    // All alike, 3 m to any side.
    tracker_.expected_at = [](const core::LevelPose& /*pose*/, int directions) {
      return std::vector<float>(static_cast<size_t>(directions), 3.0F);
    };
  }
  // As in the hall alike but within 1.5 m of a spot, which shows a near wall.
  void Differ(geometry::Vec2 spot, int level = 0) {
    tracker_.expected_at = [=](const core::LevelPose& pose, int directions) {
      const bool is_there =
          pose.place.level == level &&
          geometry::Norm(pose.map_from_base.translation - spot) < 1.5;
      return std::vector<float>(static_cast<size_t>(directions),
                                is_there ? 1.0F : 3.0F);
    };
  }
  std::optional<PartingLeg> Choose(
      const traversability::NavigationMap& map,
      const std::vector<localization::PossiblePlace>& places,
      const std::vector<geometry::Vec2>& obstacles_in_odom = {}) {
    PartingView view(map, places, odom_from_base_, obstacles_in_odom,
                     seen_from_in_odom_, kRadius_m);
    for (int i = 0; i < 1000; ++i) {
      if (view.Step(tracker_)) return view.leg();
    }
    ADD_FAILURE() << "no end";
    return std::nullopt;
  }

  ScriptedTracker tracker_;
  geometry::Rigid2 odom_from_base_ = {{100, 50}, 0.5};
  std::vector<geometry::Vec2> seen_from_in_odom_;
};

TEST_F(PartingViewTest, LeadsToWhereThePlacesDiffer) {
  const traversability::NavigationMap map = MapOf({Hall(0)});
  // The one looks along the hall, the other to its side.
  const std::vector<localization::PossiblePlace> places = {
      {.pose = PoseIn({4, 4}, 0), .share = 0.6},
      {.pose = PoseIn({14, 4}, 0), .share = 0.4}};
  Differ({8, 4});
  const std::optional<PartingLeg> leg = Choose(map, places);
  ASSERT_TRUE(leg.has_value());
  // Straight ahead of the first, in the odometry's frame; the near edge.
  EXPECT_NEAR(geometry::NormalizedAngle_rad(leg->yaw_rad - 0.5), 0, 0.4);
  EXPECT_NEAR(leg->way_m, 3, 0.8);
  EXPECT_GT(leg->gain, 0.9);
  EXPECT_LE(leg->gain, 1);
}

TEST_F(PartingViewTest, PlacesThatAreAlikeEverywhereAreNotParted) {
  const traversability::NavigationMap map = MapOf({Hall(0)});
  EXPECT_FALSE(Choose(map, {{.pose = PoseIn({4, 4}, 0), .share = 0.5},
                            {.pose = PoseIn({14, 4}, 0), .share = 0.5}})
                   .has_value());
}

TEST_F(PartingViewTest, WhatTheMapDoesNotKnowPartsNothing) {
  const traversability::NavigationMap map = MapOf({Hall(0)});
  tracker_.expected_at = [](const core::LevelPose& pose, int directions) {
    const bool is_first = pose.map_from_base.translation.x < 9;
    return std::vector<float>(
        static_cast<size_t>(directions),
        is_first ? 3.0F : std::numeric_limits<float>::quiet_NaN());
  };
  EXPECT_FALSE(Choose(map, {{.pose = PoseIn({4, 4}, 0), .share = 0.5},
                            {.pose = PoseIn({14, 4}, 0), .share = 0.5}})
                   .has_value());
}

TEST_F(PartingViewTest, TheWayIsFreeWhereverTheRobotMayBe) {
  // The other place has a wall across, 1.5 m ahead of it.
  traversability::TraversableLevel hall = Hall(0);
  for (int y = 0; y < 160; ++y) {
    for (int x = 310; x < 314; ++x) {
      hall.grid.Set({x, y}, core::Occupancy::kOccupied);
    }
  }
  const std::vector<localization::PossiblePlace> places = {
      {.pose = PoseIn({4, 4}, 0), .share = 0.9},
      {.pose = PoseIn({14, 4}, 0), .share = 0.1}};
  Differ({8, 4});
  EXPECT_FALSE(Choose(MapOf({hall}), places).has_value());
  EXPECT_TRUE(Choose(MapOf({Hall(0)}), places).has_value());
}

TEST_F(PartingViewTest, WhatWasSeenInTheWayIsGoneAround) {
  const traversability::NavigationMap map = MapOf({Hall(0)});
  odom_from_base_ = {};
  const std::vector<localization::PossiblePlace> places = {
      {.pose = PoseIn({4, 4}, 0), .share = 0.5},
      {.pose = PoseIn({14, 4}, 0), .share = 0.5}};
  Differ({8, 4});
  std::vector<geometry::Vec2> seen;
  for (int i = -10; i <= 10; ++i) seen.push_back({1.2, 0.1 * i});
  const std::optional<PartingLeg> leg = Choose(map, places, seen);
  ASSERT_TRUE(leg.has_value());
  // The first leg passes the wall's end, a metre to the side.
  EXPECT_GT(std::abs(leg->yaw_rad), 0.6);
  for (double way_m = 0; way_m < leg->way_m; way_m += 0.1) {
    for (const geometry::Vec2& obstacle : seen) {
      EXPECT_GT(geometry::Norm(way_m * geometry::Vec2{std::cos(leg->yaw_rad),
                                                      std::sin(leg->yaw_rad)} -
                               obstacle),
                kRadius_m - 0.15);
    }
  }
  // All around: nowhere.
  seen.clear();
  for (int i = 0; i < 60; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / 60;
    seen.push_back({std::cos(angle_rad), std::sin(angle_rad)});
  }
  EXPECT_FALSE(Choose(map, places, seen).has_value());
}

TEST_F(PartingViewTest, PlacesOnTwoLevelsArePartedOnBoth) {
  const traversability::NavigationMap map = MapOf({Hall(0), Hall(3)});
  const std::vector<localization::PossiblePlace> places = {
      {.pose = PoseIn({4, 4}, 0, 0, 0), .share = 0.5},
      {.pose = PoseIn({4, 4}, 0, 1, 3), .share = 0.5}};
  // The same spot of both; only the upper level has something there.
  Differ({8, 4}, 1);
  const std::optional<PartingLeg> leg = Choose(map, places);
  ASSERT_TRUE(leg.has_value());
  EXPECT_GT(leg->gain, 0.9);
  // The upper floor has no ground there: none of the way is free for it.
  traversability::TraversableLevel upper = Hall(3);
  for (int y = 0; y < 160; ++y) {
    for (int x = 100; x < 110; ++x) {
      upper.grid.Set({x, y}, core::Occupancy::kUnknown);
    }
  }
  EXPECT_FALSE(Choose(MapOf({Hall(0), upper}), places).has_value());
}

TEST_F(PartingViewTest, ALikelyPairCountsMore) {
  const traversability::NavigationMap map = MapOf({Hall(0)});
  // All look the same way; the third stands where the others lead to walls.
  const std::vector<localization::PossiblePlace> places = {
      {.pose = PoseIn({10, 2}, 0), .share = 0.45},
      {.pose = PoseIn({10, 4}, 0), .share = 0.45},
      {.pose = PoseIn({10, 6}, 0), .share = 0.1}};
  // Ahead only the unlikely one differs, behind the likely ones do.
  tracker_.expected_at = [](const core::LevelPose& pose, int directions) {
    const geometry::Vec2 at = pose.map_from_base.translation;
    const bool shows = (at.x > 12.5 && at.y > 5) || (at.x < 7.5 && at.y < 3);
    return std::vector<float>(static_cast<size_t>(directions),
                              shows ? 1.0F : 3.0F);
  };
  odom_from_base_ = {};
  const std::optional<PartingLeg> leg = Choose(map, places);
  ASSERT_TRUE(leg.has_value());
  EXPECT_GT(std::abs(leg->yaw_rad), 2);
}

TEST_F(PartingViewTest, WhatWasLookedAtBeforeGainsLess) {
  const traversability::NavigationMap map = MapOf({Hall(0)});
  const std::vector<localization::PossiblePlace> places = {
      {.pose = PoseIn({5, 2}, 0), .share = 0.5},
      {.pose = PoseIn({5, 6}, 0), .share = 0.5}};
  // Ahead and, a little further, behind.
  tracker_.expected_at = [](const core::LevelPose& pose, int directions) {
    const geometry::Vec2 at = pose.map_from_base.translation;
    const bool shows = at.y > 4 && (at.x > 7.5 || at.x < 1.2);
    return std::vector<float>(static_cast<size_t>(directions),
                              shows ? 1.0F : 3.0F);
  };
  odom_from_base_ = {};
  std::optional<PartingLeg> leg = Choose(map, places);
  ASSERT_TRUE(leg.has_value());
  EXPECT_LT(std::abs(leg->yaw_rad), 1);
  // It was there, and all around, and still does not know.
  for (int x = 2; x <= 9; ++x) {
    for (int y = -5; y <= 5; ++y) {
      seen_from_in_odom_.push_back({1.0 * x, 1.0 * y});
    }
  }
  leg = Choose(map, places);
  ASSERT_TRUE(leg.has_value());
  EXPECT_GT(std::abs(leg->yaw_rad), 2);
}

TEST_F(PartingViewTest, BoundsWhatItLooksAt) {
  const traversability::NavigationMap map = MapOf({Hall(0)});
  std::vector<localization::PossiblePlace> places;
  for (int i = 0; i < 12; ++i) {
    places.push_back({.pose = PoseIn({4.0 + i, 4}, 0), .share = 1.0 / 12});
  }
  int casts = 0;
  tracker_.expected_at = [&casts](const core::LevelPose&, int directions) {
    ++casts;
    return std::vector<float>(static_cast<size_t>(directions), 3.0F);
  };
  PartingView view(map, places, odom_from_base_, {}, {}, kRadius_m);
  EXPECT_LE(view.views(), 17u * 17u);
  int most = 0;
  for (bool is_done = false; !is_done;) {
    const int before = casts;
    is_done = view.Step(tracker_);
    most = std::max(most, casts - before);
  }
  // Eight views, and where it stands, of six places.
  EXPECT_LE(most, 54);
}

}  // namespace
}  // namespace treeline::behavior
