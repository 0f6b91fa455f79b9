#include "nav_agent/traversability/navigation_map.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "nav_agent/traversability/testing_scene.h"
#include "simulation/worlds/world.h"
#include "tests/traversable_worlds/testing_world.h"

namespace treeline {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

traversability::TraversableLevel Flat(
    int width, int height, float height_m,
    const geometry::Rigid2& map_from_grid = {}) {
  traversability::TraversableLevel level;
  level.grid = core::OccupancyGrid::Filled(width, height, 0.05, map_from_grid,
                                           core::Occupancy::kFree);
  level.height_m.assign(level.grid.cells.size(), height_m);
  level.slope_rad.assign(level.grid.cells.size(), 0);
  level.clearance_m.assign(level.grid.cells.size(), 2.5F);
  return level;
}

void SetUnknown(traversability::TraversableLevel& level, core::CellIndex cell) {
  const size_t at = level.grid.IndexOf(cell);
  level.grid.cells[at] = core::Occupancy::kUnknown;
  level.height_m[at] = kNan;
  level.slope_rad[at] = kNan;
}

traversability::NavigationMap Map(
    traversability::TraversableMap map,
    const traversability::NavigationMapOptions& options = {}) {
  auto made = traversability::NavigationMap::Make(std::move(map), options);
  EXPECT_TRUE(made.ok()) << made.status();
  return *std::move(made);
}

TEST(NavigationMapTest, ClearanceIsExactToTheNearestCellThatIsNotFree) {
  traversability::TraversableLevel level = Flat(60, 50, 0);
  level.grid.Set({20, 10}, core::Occupancy::kOccupied);
  SetUnknown(level, {40, 40});
  const core::OccupancyGrid grid = level.grid;
  const traversability::NavigationMap map =
      Map({.levels = {std::move(level)}, .joins = {}});
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      // What lies outside is not free either.
      double expected = std::min({x + 1, y + 1, 60 - x, 50 - y});
      expected = std::min(expected, std::hypot(x - 20, y - 10));
      expected = std::min(expected, std::hypot(x - 40, y - 40));
      ASSERT_NEAR(map.ClearanceAt_m(0, {x, y}), 0.05 * expected, 1e-6)
          << x << ", " << y;
    }
  }
}

TEST(NavigationMapTest, ClearanceOfAPointIsBetweenThoseOfCellsAround) {
  traversability::TraversableLevel level =
      Flat(60, 60, 0, {.translation = {3, -2}, .yaw_rad = 0.5});
  level.grid.Set({30, 30}, core::Occupancy::kOccupied);
  const core::OccupancyGrid grid = level.grid;
  const traversability::NavigationMap map =
      Map({.levels = {std::move(level)}, .joins = {}});
  const geometry::Vec2 a = grid.CenterInMap({35, 30});
  const geometry::Vec2 b = grid.CenterInMap({36, 30});
  EXPECT_NEAR(map.Clearance_m(0, a), 0.25, 1e-6);
  EXPECT_NEAR(map.Clearance_m(0, b), 0.30, 1e-6);
  EXPECT_NEAR(map.Clearance_m(0, 0.5 * (a + b)), 0.275, 1e-6);
  EXPECT_EQ(map.Clearance_m(0, {1e30, 0}), 0);
  EXPECT_EQ(map.Clearance_m(0, {std::nan(""), 0}), 0);
}

TEST(NavigationMapTest, UnknownGroundIsFreeOnlyIfAllowed) {
  traversability::TraversableLevel level = Flat(40, 40, 0);
  SetUnknown(level, {20, 20});
  const traversability::TraversableMap levels = {.levels = {level},
                                                 .joins = {}};
  EXPECT_FALSE(Map(levels).IsFree(0, {20, 20}));
  EXPECT_EQ(Map(levels).ClearanceAt_m(0, {20, 20}), 0);
  const traversability::NavigationMap open =
      Map(levels, {.reach_m = 3, .max_rise_m = 0.3, .allow_unknown = true});
  EXPECT_TRUE(open.IsFree(0, {20, 20}));
  EXPECT_GT(open.ClearanceAt_m(0, {20, 20}), 0.9);
}

TEST(NavigationMapTest, MapsWithoutFreeGroundAreRefused) {
  traversability::TraversableLevel level = Flat(4, 4, 0);
  level.grid.cells.assign(16, core::Occupancy::kOccupied);
  const auto made = traversability::NavigationMap::Make(
      {.levels = {std::move(level)}, .joins = {}});
  EXPECT_EQ(made.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(made.status().message()),
              testing::HasSubstr("no free ground"));
  EXPECT_FALSE(traversability::NavigationMap::Make({}).ok());
}

// The left half below and the right half 0.1 m higher are joined at x = 30;
// the upper one goes on above the lower one's ground, 2.5 m higher, at y >= 30.
traversability::TraversableMap Joined() {
  traversability::TraversableMap map;
  map.levels = {Flat(80, 60, 0.0F), Flat(80, 60, 0.1F)};
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) {
      if (x >= 30) SetUnknown(map.levels[0], {x, y});
      if (x < 30) SetUnknown(map.levels[1], {x, y});
      // Above: a balcony without a wall below.
      if (x >= 30 && y >= 30) {
        map.levels[1].height_m[map.levels[1].grid.IndexOf({x, y})] = 2.5F;
      }
    }
  }
  map.joins = {{.lower_level = 0, .upper_level = 1, .cells = {{29, 10}}}};
  return map;
}

TEST(NavigationMapTest, GroundBeyondAJoinIsFreeGroundAboveIsNot) {
  const traversability::NavigationMap map = Map(Joined());
  // 0.5 m beyond the join, still far from anything.
  EXPECT_GT(map.ClearanceAt_m(0, {35, 12}), 0.5);
  EXPECT_FALSE(map.IsFree(0, {35, 12}));
  // The floor that is 2.5 m higher is not ground of the lower level.
  EXPECT_EQ(map.ClearanceAt_m(0, {30, 45}), 0);
  EXPECT_NEAR(map.ClearanceAt_m(0, {29, 45}), 0.05, 1e-6);
}

TEST(NavigationMapTest, WhatMovesOverAJoinGoesOverToTheOtherLevel) {
  const traversability::NavigationMap map = Map(Joined());
  const auto before = map.GroundNear({1.4, 0.5}, 0.025);
  ASSERT_TRUE(before.has_value());
  EXPECT_EQ(before->level, 0);
  const auto beyond = map.GroundNear({1.6, 0.5}, before->height_m);
  ASSERT_TRUE(beyond.has_value());
  EXPECT_EQ(beyond->level, 1);
  EXPECT_NEAR(beyond->height_m, 0.125, 1e-6);
  EXPECT_FALSE(map.GroundNear({1.6, 2.0}, before->height_m).has_value());
  EXPECT_FALSE(map.GroundNear({-1, 0}, 0).has_value());
}

// A ramp of 1:12 and 1.2 m width on a floor, turned by yaw_rad.
traversability::Scene RampScene(double yaw_rad) {
  traversability::Scene scene = traversability::Scene::WithFloor(8, 8);
  scene.blocks.push_back(
      {.kind = traversability::BlockKind::kGround,
       .scene_from_block = {.translation = {4, 4}, .yaw_rad = yaw_rad},
       .half_x_m = 2.4,
       .half_y_m = 0.6,
       .top_begin_m = traversability::Scene::kFloor_m,
       .top_end_m = traversability::Scene::kFloor_m + 0.4});
  return scene;
}

TEST(NavigationMapTest, SidesOfARampAreBlockedDownToItsFoot) {
  for (const double yaw_rad : {0.0, 0.4, std::numbers::pi / 4}) {
    const traversability::Scene scene = RampScene(yaw_rad);
    const auto levels =
        traversability::ExtractTraversableMap(traversability::Voxelize(scene));
    ASSERT_TRUE(levels.ok());
    const traversability::NavigationMap map = Map(*levels);
    const geometry::Rigid2& scene_from_ramp =
        scene.blocks.back().scene_from_block;
    // A wheel's way across a side. Nearer to the foot the ramp lies in the
    // floor's own voxels, which end 3.7 cm above it.
    for (double along_m = 0.5; along_m < 1.0; along_m += 0.05) {
      for (const double side : {-1.0, 1.0}) {
        bool is_blocked = false;
        for (double y_m = 0.3; y_m < 0.9; y_m += 0.01) {
          const geometry::Vec2 at =
              scene_from_ramp * geometry::Vec2{along_m - 2.4, side * y_m};
          is_blocked = is_blocked || !map.IsFree(0, map.grid(0).CellOf(at));
        }
        EXPECT_TRUE(is_blocked) << "yaw " << yaw_rad << ", side " << side
                                << ", " << along_m << " m from the foot";
      }
    }
    // The way up its middle is free.
    for (double along_m = -0.5; along_m < 4.2; along_m += 0.05) {
      for (const double side_m : {-0.35, 0.0, 0.35}) {
        const geometry::Vec2 at =
            scene_from_ramp * geometry::Vec2{along_m - 2.4, side_m};
        EXPECT_TRUE(map.IsFree(0, map.grid(0).CellOf(at)))
            << "yaw " << yaw_rad << ", " << along_m << " m, " << side_m;
      }
    }
  }
}

// The ramp of RampScene, and a landing 0.4 m high beyond its upper end and
// beside it, to the left.
traversability::Scene RampWithLanding(double yaw_rad) {
  traversability::Scene scene = RampScene(yaw_rad);
  const geometry::Rigid2 scene_from_ramp = scene.blocks.back().scene_from_block;
  const auto add = [&](geometry::Vec2 middle, double half_x_m,
                       double half_y_m) {
    scene.blocks.push_back(
        {.kind = traversability::BlockKind::kGround,
         .scene_from_block = scene_from_ramp * geometry::Rigid2{middle, 0},
         .half_x_m = half_x_m,
         .half_y_m = half_y_m,
         .top_begin_m = traversability::Scene::kFloor_m + 0.4,
         .top_end_m = traversability::Scene::kFloor_m + 0.4});
  };
  add({0.9, 1.2}, 2.3, 0.6);
  add({2.8, 0}, 0.4, 0.6);
  return scene;
}

TEST(NavigationMapTest, SidesOfARampAreBlockedUpToTheFloorThatItLeadsTo) {
  for (const double yaw_rad : {0.0, 0.4}) {
    const traversability::Scene scene = RampWithLanding(yaw_rad);
    const auto levels =
        traversability::ExtractTraversableMap(traversability::Voxelize(scene));
    ASSERT_TRUE(levels.ok());
    const traversability::NavigationMap map = Map(*levels);
    const geometry::Rigid2& scene_from_ramp = scene.blocks[1].scene_from_block;
    // Over the side between ramp and landing. The ramp lies 9 to 5 cm below
    // the landing there; further up it is in the landing's own voxels.
    for (double along_m = 3.7; along_m < 4.2; along_m += 0.05) {
      bool is_blocked = false;
      for (double y_m = 0.3; y_m < 0.9; y_m += 0.01) {
        const geometry::Vec2 at =
            scene_from_ramp * geometry::Vec2{along_m - 2.4, y_m};
        is_blocked = is_blocked || !map.IsFree(0, map.grid(0).CellOf(at));
      }
      EXPECT_TRUE(is_blocked) << "yaw " << yaw_rad << ", " << along_m << " m";
    }
    // From the ramp onto the landing, and over the landing beside its end.
    for (double along_m = 0; along_m < 5.4; along_m += 0.05) {
      const geometry::Vec2 up =
          scene_from_ramp * geometry::Vec2{along_m - 2.4, 0};
      EXPECT_TRUE(map.IsFree(0, map.grid(0).CellOf(up)))
          << "yaw " << yaw_rad << ", " << along_m << " m";
      if (along_m < 2.6) continue;
      const geometry::Vec2 beside =
          scene_from_ramp * geometry::Vec2{along_m - 2.4, 1.2};
      EXPECT_TRUE(map.IsFree(0, map.grid(0).CellOf(beside)))
          << "yaw " << yaw_rad << ", " << along_m << " m, beside";
    }
  }
}

TEST(NavigationMapTest, AnotherRampBehindAWallBlocksNothing) {
  // Up the one along x; the other one, behind a wall at its right side, leads
  // along y, so that the one's own steps lie across it.
  traversability::Scene scene = RampScene(0);
  scene.AddBox(traversability::BlockKind::kObstacle, {1.0, 3.2}, {7.0, 3.3},
               1.5);
  scene.blocks.push_back({.kind = traversability::BlockKind::kGround,
                          .scene_from_block = {.translation = {4, 1.7},
                                               .yaw_rad = std::numbers::pi / 2},
                          .half_x_m = 1.5,
                          .half_y_m = 2.4,
                          .top_begin_m = traversability::Scene::kFloor_m,
                          .top_end_m = traversability::Scene::kFloor_m + 0.3});
  const auto levels =
      traversability::ExtractTraversableMap(traversability::Voxelize(scene));
  ASSERT_TRUE(levels.ok());
  const traversability::NavigationMap map = Map(*levels);
  for (double x_m = 1.2; x_m < 6.2; x_m += 0.05) {
    for (const double y_m : {3.65, 4.0, 4.35}) {
      EXPECT_TRUE(map.IsFree(0, map.grid(0).CellOf({x_m, y_m})))
          << x_m << ", " << y_m;
    }
  }
}

// As in a map that was driven: the floors' surface lies between two voxels, so
// that it is in either, here in one more often and there in the other.
traversability::TraversableLevel WithFloorsThatScatter(
    const traversability::Scene& ramp, traversability::TraversableLevel level,
    uint64_t seed) {
  const geometry::Rigid2 ramp_from_scene =
      ramp.blocks[1].scene_from_block.Inverse();
  base::Random random(seed, 0);
  const double phase = random.NextUniform(0, 6);
  for (int y = 0; y < level.grid.height; ++y) {
    for (int x = 0; x < level.grid.width; ++x) {
      const geometry::Vec2 at = level.grid.CenterInMap({x, y});
      const geometry::Vec2 on_ramp = ramp_from_scene * at;
      const double part =
          0.5 + 0.5 * std::sin(4 * at.x + phase) * std::cos(3 * at.y + phase);
      if (std::abs(on_ramp.x) < 2.4 && std::abs(on_ramp.y) < 0.6) continue;
      const size_t i = level.grid.IndexOf({x, y});
      if (random.NextUnit() < part) level.height_m[i] += 0.05F;
      level.slope_rad[i] += 0.04F;
    }
  }
  return level;
}

TEST(NavigationMapTest, FloorsThatScatterBesideARampStayWhole) {
  for (const uint64_t seed : {1, 2, 3, 4, 5}) {
    const traversability::Scene scene = RampWithLanding(0.4);
    auto levels =
        traversability::ExtractTraversableMap(traversability::Voxelize(scene));
    ASSERT_TRUE(levels.ok());
    ASSERT_EQ(levels->levels.size(), 1);
    levels->levels[0] =
        WithFloorsThatScatter(scene, std::move(levels->levels[0]), seed);
    const traversability::NavigationMap map = Map(*levels);
    const geometry::Rigid2 ramp_from_scene =
        scene.blocks[1].scene_from_block.Inverse();
    int floor = 0;
    int blocked = 0;
    for (int y = 0; y < map.grid(0).height; ++y) {
      for (int x = 0; x < map.grid(0).width; ++x) {
        if (levels->levels[0].grid.At({x, y}) != core::Occupancy::kFree) {
          continue;
        }
        // All but the ramp's sides.
        const geometry::Vec2 on_ramp =
            ramp_from_scene * map.grid(0).CenterInMap({x, y});
        const double beside_m = std::abs(std::abs(on_ramp.y) - 0.6);
        if (beside_m < 0.2 && std::abs(on_ramp.x) < 2.5) continue;
        ++floor;
        if (!map.IsFree(0, {x, y})) ++blocked;
      }
    }
    EXPECT_GT(floor, 15000);
    EXPECT_LE(blocked, 5) << "seed " << seed;
  }
}

TEST(NavigationMapTest, FloorsOfTiltedMapsStayWhole) {
  // Half a degree: from one voxel to the next after 5.7 m.
  traversability::Scene scene = traversability::Scene::WithFloor(8, 8);
  scene.blocks[0].top_begin_m = 0.001;
  scene.blocks[0].top_end_m = 0.071;
  const auto levels =
      traversability::ExtractTraversableMap(traversability::Voxelize(scene));
  ASSERT_TRUE(levels.ok());
  const traversability::NavigationMap map = Map(*levels);
  for (size_t i = 0; i < map.grid(0).cells.size(); ++i) {
    EXPECT_EQ(map.grid(0).cells[i], levels->levels[0].grid.cells[i]);
  }
}

}  // namespace
}  // namespace treeline
