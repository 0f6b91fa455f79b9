#include "nav_agent/traversability/traversability.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/traversability/testing_scene.h"

namespace treeline::traversability {
namespace {

using testing::HasSubstr;

constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr double kRobotHeight_m = 1.25;
// The brief's: voxels missed, and voxels too many.
constexpr VoxelNoise kNoise{
    .seed = 3, .dropped = 0.05, .near = 0.005, .far = 1e-4};

TraversableMap Extract(const octree::VoxelMap& voxels) {
  absl::StatusOr<TraversableMap> map = ExtractTraversableMap(voxels);
  EXPECT_TRUE(map.ok()) << map.status();
  return *std::move(map);
}

// Right, and nothing dangerous is free.
void ExpectSafe(const Scene& scene, const TraversableLevel& level,
                double begin_z_m = -1, double end_z_m = 100) {
  const Score score =
      ScoreLevel(scene, level, kRobotHeight_m, begin_z_m, end_z_m);
  EXPECT_GE(score.RightShare(), 0.99)
      << score.wrong << " of " << score.cells << " cells are wrong";
  EXPECT_EQ(score.free_stairs, 0);
  EXPECT_EQ(score.free_edges, 0);
}

// In the middle of a floor of 7 x 7 m something of `length_m` rises to a
// platform, turned by yaw_rad about the middle.
struct Climb {
  Scene scene = Scene::WithFloor(7, 7);
  geometry::Rigid2 scene_from_climb;
  double height_m = 0;

  geometry::Vec2 At(double x, double y) const {
    return scene_from_climb * geometry::Vec2{x, y};
  }
  void Add(BlockKind kind, double begin_x, double end_x, double top_begin_m,
           double top_end_m, double half_width_m = 0.75) {
    Block block{
        .kind = kind,
        .scene_from_block = {.translation = At((begin_x + end_x) / 2, 0),
                             .yaw_rad = scene_from_climb.yaw_rad},
        .half_x_m = (end_x - begin_x) / 2,
        .half_y_m = half_width_m,
        .top_begin_m = top_begin_m,
        .top_end_m = top_end_m};
    scene.blocks.push_back(block);
  }
};

constexpr double kRampLength_m = 2.5;
constexpr double kPlatform_m = 1.5;

Climb MakeRamp(double slope_deg, double yaw_deg) {
  Climb climb;
  climb.scene_from_climb = {.translation = {3.52, 3.47},
                            .yaw_rad = yaw_deg * kRadPerDeg};
  climb.height_m =
      Scene::kFloor_m + kRampLength_m * std::tan(slope_deg * kRadPerDeg);
  climb.Add(BlockKind::kGround, -2, -2 + kRampLength_m, Scene::kFloor_m,
            climb.height_m);
  climb.Add(BlockKind::kGround, -2 + kRampLength_m,
            -2 + kRampLength_m + kPlatform_m, climb.height_m, climb.height_m);
  return climb;
}

Climb MakeStairs(double rise_m, double run_m, int steps, double yaw_deg) {
  Climb climb;
  climb.scene_from_climb = {.translation = {3.52, 3.47},
                            .yaw_rad = yaw_deg * kRadPerDeg};
  double x = -2;
  double z = Scene::kFloor_m;
  for (int i = 0; i < steps; ++i) {
    z += rise_m;
    climb.Add(BlockKind::kStairs, x, x + run_m, z, z);
    x += run_m;
  }
  // The last riser leads to the platform, whose first part is the last tread.
  climb.height_m = z + rise_m;
  climb.Add(BlockKind::kStairs, x, x + run_m, climb.height_m, climb.height_m);
  // Nothing but stairs joins it to the floor, so it is large enough to be no
  // furniture.
  climb.Add(BlockKind::kGround, x + run_m, x + 2.2, climb.height_m,
            climb.height_m, 1.1);
  return climb;
}

TEST(LayerGradient, IsEquation6_2) {
  // A ramp of 1:12 at d = r = 0.05 m has layers whose edges are 12 voxels
  // apart.
  EXPECT_NEAR(LayerGradient_rad(0.05, 0.05, 12), std::atan(1.0 / 12), 1e-12);
  EXPECT_NEAR(LayerGradient_rad(0.05, 0.05, 12) / kRadPerDeg, 4.76, 0.01);
  EXPECT_NEAR(LayerGradient_rad(0.05, 0.05, 11) / kRadPerDeg, 5.19, 0.01);
  EXPECT_NEAR(LayerGradient_rad(0.1, 0.05, 2), std::numbers::pi / 4, 1e-12);
}

TEST(LayerGradient, NoRunIsNinetyDegrees) {
  EXPECT_DOUBLE_EQ(LayerGradient_rad(0.05, 0.05, 0), std::numbers::pi / 2);
}

TEST(Traversability, GentleRampsInAllDirectionsLeadToTheirPlatforms) {
  for (const double slope_deg : {3.0, 5.0, 8.0, 12.0, 15.0}) {
    for (const double yaw_deg : {0.0, 30.0, 225.0}) {
      for (const VoxelNoise& noise : {VoxelNoise{}, kNoise}) {
        if (yaw_deg == 225 && noise.dropped == 0) continue;
        SCOPED_TRACE(absl::StrCat(slope_deg, " deg, turned by ", yaw_deg,
                                  ", noise ", noise.dropped));
        const Climb climb = MakeRamp(slope_deg, yaw_deg);
        const TraversableMap map = Extract(Voxelize(climb.scene, noise));
        ASSERT_EQ(map.levels.size(), 1u);
        ExpectSafe(climb.scene, map.levels[0]);
        EXPECT_TRUE(AreConnected(map.levels[0].grid, climb.At(-2.5, 0),
                                 climb.At(1.2, 0)));
      }
    }
  }
}

TEST(Traversability, CellsOfARampCarryItsSlopeAndHeight) {
  for (const double slope_deg : {3.0, 5.0, 8.0, 12.0, 15.0}) {
    for (const double yaw_deg : {0.0, 30.0}) {
      SCOPED_TRACE(absl::StrCat(slope_deg, " deg, turned by ", yaw_deg));
      const Climb climb = MakeRamp(slope_deg, yaw_deg);
      const TraversableMap map = Extract(Voxelize(climb.scene, kNoise));
      const TraversableLevel& level = map.levels[0];
      // Half a metre from where the slope changes.
      int cells = 0;
      int far_off = 0;
      double squares = 0;
      for (double x = -1.5; x <= 0; x += 0.05) {
        for (double y = -0.5; y <= 0.5; y += 0.05) {
          const size_t cell =
              level.grid.IndexOf(level.grid.CellOf(climb.At(x, y)));
          const double error_deg =
              level.slope_rad[cell] / kRadPerDeg - slope_deg;
          const double true_m =
              Scene::kFloor_m + (x + 2) * std::tan(slope_deg * kRadPerDeg);
          ++cells;
          // A voxel's half, its extent along the slope, and a missed voxel;
          // and the part of the rounding's period that passes the bell.
          if (std::abs(error_deg) > 2.5 ||
              std::abs(level.height_m[cell] - true_m) > 0.08) {
            ++far_off;
          } else {
            squares += error_deg * error_deg;
          }
        }
      }
      EXPECT_LE(far_off, 0.01 * cells);
      EXPECT_LE(std::sqrt(squares / cells), 1.5);
    }
  }
}

TEST(Traversability, SteepRampsAreOccupied) {
  for (const double slope_deg : {19.0, 25.0, 35.0}) {
    for (const double yaw_deg : {0.0, 30.0}) {
      SCOPED_TRACE(absl::StrCat(slope_deg, " deg, turned by ", yaw_deg));
      const Climb climb = MakeRamp(slope_deg, yaw_deg);
      const TraversableMap map = Extract(Voxelize(climb.scene, kNoise));
      const core::OccupancyGrid& grid = map.levels[0].grid;
      EXPECT_FALSE(AreConnected(grid, climb.At(-2.5, 0), climb.At(1.2, 0)));
      int free = 0;
      int cells = 0;
      for (double x = -1.6; x <= 0.1; x += 0.05) {
        for (double y = -0.6; y <= 0.6; y += 0.05) {
          ++cells;
          if (grid.At(grid.CellOf(climb.At(x, y))) == core::Occupancy::kFree)
            ++free;
        }
      }
      EXPECT_LE(free, 0.01 * cells);
    }
  }
}

TEST(Traversability, NoStairsAreFree) {
  for (const double rise_m : {0.15, 0.17, 0.20}) {
    for (const double run_m : {0.24, 0.28, 0.32}) {
      for (const double yaw_deg : {0.0, 30.0, 45.0}) {
        for (const VoxelNoise& noise : {VoxelNoise{}, kNoise}) {
          if (yaw_deg != 30 && noise.dropped == 0) continue;
          SCOPED_TRACE(absl::StrCat(rise_m, " x ", run_m, " m, turned by ",
                                    yaw_deg, ", noise ", noise.dropped));
          const Climb climb = MakeStairs(rise_m, run_m, 6, yaw_deg);
          const TraversableMap map = Extract(Voxelize(climb.scene, noise));
          ASSERT_EQ(map.levels.size(), 1u);
          ExpectSafe(climb.scene, map.levels[0]);
        }
      }
    }
  }
}

// With each column's tops moved up or down by a normal draw (voxels).
octree::VoxelMap Scattered(const octree::VoxelMap& exact, double deviation) {
  octree::VoxelMap map = exact;
  base::Random random(5, 0);
  for (int y = 0; y < map.size().y; ++y) {
    for (int x = 0; x < map.size().x; ++x) {
      const auto by =
          static_cast<int>(std::lround(deviation * random.NextGaussian()));
      for (int z = 0; z < map.size().z; ++z) {
        const int from = std::clamp(z - by, 0, map.size().z - 1);
        map.Set({x, y, z}, exact.At({x, y, from}));
      }
    }
  }
  return map;
}

double FreeShare(const core::OccupancyGrid& grid) {
  return static_cast<double>(
             std::ranges::count(grid.cells, core::Occupancy::kFree)) /
         static_cast<double>(grid.cells.size());
}

TEST(Traversability, FloorsThatScatterAreFree) {
  const Scene scene = Scene::WithFloor(6, 6);
  for (const double deviation : {0.6, 1.0}) {
    const TraversableMap map = Extract(Scattered(Voxelize(scene), deviation));
    EXPECT_GT(FreeShare(map.levels.at(0).grid), 0.95) << deviation;
  }
}

// Kerbs of two voxels, and of three where tops scatter by one, are below what
// can be told from the scatter.
TEST(Traversability, StairsAndKerbsStaySoWhereTheyScatter) {
  for (const double deviation : {0.6, 1.0}) {
    SCOPED_TRACE(absl::StrCat("deviation ", deviation));
    const Climb stairs = MakeStairs(0.17, 0.28, 6, 30);
    const TraversableMap climbed =
        Extract(Scattered(Voxelize(stairs.scene), deviation));
    EXPECT_FALSE(AreConnected(climbed.levels.at(0).grid, stairs.At(-2.5, 0),
                              stairs.At(1.2, 0)));
    for (const double kerb_m : {0.15, 0.2, 0.4}) {
      if (kerb_m < 0.2 && deviation > 0.6) continue;
      Scene scene = Scene::WithFloor(6, 6);
      scene.AddBox(BlockKind::kGround, {3.02, 0}, {6, 6},
                   Scene::kFloor_m + kerb_m);
      const TraversableMap map = Extract(Scattered(Voxelize(scene), deviation));
      EXPECT_FALSE(AreConnected(map.levels.at(0).grid, {1, 3}, {5, 3}))
          << kerb_m;
    }
  }
}

TEST(Traversability, TheEdgesOfPlatformsAreSteepestOfAll) {
  Scene scene = Scene::WithFloor(6, 6);
  scene.AddBox(BlockKind::kGround, {2.02, 0}, {6, 6}, 0.4);
  const TraversableMap map = Extract(Voxelize(scene));
  const TraversableLevel& level = map.levels[0];
  ExpectSafe(scene, level);
  const size_t edge = level.grid.IndexOf({40, 60});
  EXPECT_EQ(level.grid.cells[edge], core::Occupancy::kOccupied);
  EXPECT_NEAR(level.slope_rad[edge], std::numbers::pi / 2, 1e-6);
  EXPECT_EQ(level.grid.At({42, 60}), core::Occupancy::kFree);
  EXPECT_EQ(level.grid.At({38, 60}), core::Occupancy::kFree);
}

// A table, walls, a pillar, a door's threshold and a low beam.
Scene MakeRoom() {
  Scene scene = Scene::WithFloor(6, 6);
  scene.AddBox(BlockKind::kObstacle, {0, 0}, {6, 0.12}, 2.5);
  scene.AddBox(BlockKind::kObstacle, {0, 0}, {0.12, 6}, 2.5);
  scene.AddBox(BlockKind::kObstacle, {3.5, 3.5}, {3.83, 3.83}, 2.5);
  scene.AddBox(BlockKind::kObstacle, {1, 1}, {2.4, 1.8}, 0.74, 0.04);
  for (const geometry::Vec2 leg :
       {geometry::Vec2{1, 1}, {2.35, 1}, {1, 1.75}, {2.35, 1.75}}) {
    scene.AddBox(BlockKind::kObstacle, leg, leg + geometry::Vec2{0.05, 0.05},
                 0.72);
  }
  scene.AddBox(BlockKind::kGround, {4, 0.12}, {4.1, 6}, Scene::kFloor_m + 0.02);
  scene.AddBox(BlockKind::kObstacle, {4.6, 1}, {4.8, 5}, 1.3, 0.2);
  scene.AddBox(BlockKind::kObstacle, {5.2, 1}, {5.4, 5}, 1.7, 0.2);
  return scene;
}

TEST(Traversability, FurnitureAndLowBeamsAreOccupiedAndThresholdsFree) {
  for (const VoxelNoise& noise : {VoxelNoise{}, kNoise}) {
    const Scene scene = MakeRoom();
    const TraversableMap map = Extract(Voxelize(scene, noise));
    ASSERT_EQ(map.levels.size(), 1u);
    const TraversableLevel& level = map.levels[0];
    ExpectSafe(scene, level);
    const core::OccupancyGrid& grid = level.grid;
    const size_t under_table = grid.IndexOf(grid.CellOf({1.7, 1.4}));
    EXPECT_EQ(grid.cells[under_table], core::Occupancy::kOccupied);
    EXPECT_NEAR(level.height_m[under_table], 0.025, 0.051);
    EXPECT_NEAR(level.clearance_m[under_table], 0.65, 0.051);
    // Under the beam at 1.5 m, and over the threshold.
    EXPECT_TRUE(AreConnected(grid, {3, 3}, {5.7, 3}));
  }
}

TEST(Traversability, LowerRobotsPassUnderTables) {
  TraversabilityOptions options;
  options.robot_height_m = 0.5;
  const TraversableMap map =
      *ExtractTraversableMap(Voxelize(MakeRoom()), options);
  const core::OccupancyGrid& grid = map.levels[0].grid;
  EXPECT_EQ(grid.At(grid.CellOf({1.7, 1.4})), core::Occupancy::kFree);
}

TEST(Traversability, HigherStepsMayBeAllowed) {
  Scene scene = Scene::WithFloor(4, 4);
  scene.AddBox(BlockKind::kGround, {2, 0}, {4, 4}, Scene::kFloor_m + 0.1);
  const octree::VoxelMap voxels = Voxelize(scene);
  TraversabilityOptions options;
  EXPECT_FALSE(AreConnected(
      ExtractTraversableMap(voxels, options)->levels[0].grid, {1, 2}, {3, 2}));
  options.max_step_m = 0.1;
  EXPECT_TRUE(AreConnected(
      ExtractTraversableMap(voxels, options)->levels[0].grid, {1, 2}, {3, 2}));
}

constexpr double kUpperFloor_m = 2.6;

// An upper floor over most of the lower one, and a ramp of 14.6 degrees that
// floats up to it.
Scene MakeTwoFloors() {
  Scene scene = Scene::WithFloor(14, 6);
  scene.top_m = 4.6;
  scene.AddBox(BlockKind::kGround, {0, 2}, {14, 6}, kUpperFloor_m, 0.2);
  scene.AddBox(BlockKind::kGround, {12, 0}, {14, 2}, kUpperFloor_m, 0.2);
  scene.blocks.push_back(
      {.kind = BlockKind::kGround,
       .scene_from_block = {.translation = {7, 0.75}, .yaw_rad = 0},
       .half_x_m = 5,
       .half_y_m = 0.75,
       .top_begin_m = Scene::kFloor_m,
       .top_end_m = kUpperFloor_m,
       .thickness_m = 0.15});
  return scene;
}

// What a level covers, to half a voxel.
constexpr double kHalf_m = 0.025;

double LowestFree_m(const TraversableLevel& level) {
  double lowest_m = 1e9;
  for (size_t i = 0; i < level.grid.cells.size(); ++i) {
    if (level.grid.cells[i] != core::Occupancy::kFree) continue;
    lowest_m = std::min<double>(lowest_m, level.height_m[i]);
  }
  return lowest_m;
}

double HighestFree_m(const TraversableLevel& level) {
  double highest_m = -1e9;
  for (size_t i = 0; i < level.grid.cells.size(); ++i) {
    if (level.grid.cells[i] != core::Occupancy::kFree) continue;
    highest_m = std::max<double>(highest_m, level.height_m[i]);
  }
  return highest_m;
}

TEST(Traversability, FloorsThatOverlapAreLevelsJoinedByTheirRamp) {
  for (const VoxelNoise& noise : {VoxelNoise{}, kNoise}) {
    SCOPED_TRACE(noise.dropped);
    const Scene scene = MakeTwoFloors();
    const TraversableMap map = Extract(Voxelize(scene, noise));
    ASSERT_EQ(map.levels.size(), 2u);
    ASSERT_GE(map.joins.size(), 1u);
    ExpectSafe(scene, map.levels[0], -1,
               HighestFree_m(map.levels[0]) + kHalf_m);
    ExpectSafe(scene, map.levels[1], LowestFree_m(map.levels[1]) - kHalf_m,
               100);
    const LevelJoin& ramp =
        *std::max_element(map.joins.begin(), map.joins.end(),
                          [](const LevelJoin& a, const LevelJoin& b) {
                            return a.cells.size() < b.cells.size();
                          });
    const core::CellIndex join = ramp.cells[ramp.cells.size() / 2];
    const geometry::Vec2 door = map.levels[0].grid.CenterInMap(join);
    EXPECT_TRUE(AreConnected(map.levels[0].grid, {1, 4}, door));
    EXPECT_TRUE(AreConnected(map.levels[1].grid, door, {2, 4}));
    EXPECT_NEAR(map.levels[1].height_m[map.levels[1].grid.IndexOf({20, 80})],
                kUpperFloor_m, 0.051);
  }
}

TEST(Traversability, FloorsWithoutARampAreLevelsWithoutAJoin) {
  Scene scene = Scene::WithFloor(6, 6);
  scene.top_m = 4.6;
  scene.AddBox(BlockKind::kGround, {0, 0}, {6, 3}, kUpperFloor_m, 0.2);
  const TraversableMap map = Extract(Voxelize(scene));
  EXPECT_EQ(map.levels.size(), 2u);
  EXPECT_TRUE(map.joins.empty());
}

TEST(Traversability, WhatNobodySawIsUnknown) {
  octree::VoxelMap voxels = Voxelize(Scene::WithFloor(4, 4));
  for (int y = 0; y < 80; ++y) {
    for (int x = 40; x < 80; ++x) {
      voxels.SetRun(x, y, 0, voxels.size().z, octree::Voxel::kUnknown);
    }
  }
  // The underside of a ceiling is no floor from above.
  for (int x = 0; x < 40; ++x) {
    voxels.Set({x, 10, 55}, octree::Voxel::kOccupied);
    voxels.SetRun(x, 10, 56, voxels.size().z, octree::Voxel::kUnknown);
  }
  const core::OccupancyGrid grid = Extract(voxels).levels[0].grid;
  EXPECT_EQ(grid.At({60, 40}), core::Occupancy::kUnknown);
  // Ground that ends where the view did is no edge.
  EXPECT_EQ(grid.At({39, 40}), core::Occupancy::kFree);
  EXPECT_EQ(grid.At({20, 10}), core::Occupancy::kFree);
}

bool SameValues(const std::vector<float>& a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](float x, float y) {
                      return x == y || (std::isnan(x) && std::isnan(y));
                    });
}

void ExpectSame(const TraversableMap& a, const TraversableMap& b) {
  ASSERT_EQ(a.levels.size(), b.levels.size());
  for (size_t i = 0; i < a.levels.size(); ++i) {
    EXPECT_EQ(a.levels[i].grid.cells, b.levels[i].grid.cells);
    EXPECT_TRUE(SameValues(a.levels[i].height_m, b.levels[i].height_m));
    EXPECT_TRUE(SameValues(a.levels[i].slope_rad, b.levels[i].slope_rad));
    EXPECT_TRUE(SameValues(a.levels[i].clearance_m, b.levels[i].clearance_m));
  }
  ASSERT_EQ(a.joins.size(), b.joins.size());
  for (size_t i = 0; i < a.joins.size(); ++i) {
    EXPECT_EQ(a.joins[i].cells, b.joins[i].cells);
  }
}

TEST(Traversability, UpdatesGiveExactlyWhatANewExtractionGives) {
  octree::VoxelMap voxels = Voxelize(MakeTwoFloors(), kNoise);
  absl::StatusOr<TraversabilityMapper> mapper =
      TraversabilityMapper::Make(TraversabilityOptions());
  ASSERT_TRUE(mapper.ok());
  ASSERT_TRUE(mapper->Rebuild(voxels).ok());
  base::Random random(9, 0);
  for (int change = 0; change < 12; ++change) {
    SCOPED_TRACE(change);
    const auto below = [&random](int bound) {
      return static_cast<int>(random.NextBelow(static_cast<uint32_t>(bound)));
    };
    // Boxes that come, go, and dig holes; at the map's border as well.
    const int x = below(voxels.size().x - 20);
    const int y = change % 3 == 0 ? 0 : below(voxels.size().y - 20);
    const int z = below(voxels.size().z - 12);
    const int width = 1 + below(20);
    const auto value = static_cast<octree::Voxel>(below(3));
    for (int dy = 0; dy < width; ++dy) {
      for (int dx = 0; dx < width; ++dx) {
        voxels.SetRun(x + dx, y + dy, z, z + 1 + below(12), value);
      }
    }
    ASSERT_TRUE(mapper->Update(voxels, {x, y, x + width, y + width}).ok());
    ExpectSame(mapper->map(), Extract(voxels));
  }
}

TEST(Traversability, AMapThatGrowsIsRebuilt) {
  absl::StatusOr<TraversabilityMapper> mapper =
      TraversabilityMapper::Make(TraversabilityOptions());
  ASSERT_TRUE(mapper->Rebuild(Voxelize(Scene::WithFloor(3, 3))).ok());
  const octree::VoxelMap larger = Voxelize(Scene::WithFloor(4, 3));
  ASSERT_TRUE(mapper->Update(larger, {0, 0, 1, 1}).ok());
  ExpectSame(mapper->map(), Extract(larger));
}

TEST(Traversability, EmptyMapsAreErrors) {
  EXPECT_EQ(ExtractTraversableMap(octree::VoxelMap()).status().code(),
            absl::StatusCode::kInvalidArgument);
  octree::VoxelMap free = *octree::VoxelMap::Make(0.05, {}, {10, 10, 10});
  free.SetRun(0, 0, 0, 10, octree::Voxel::kFree);
  EXPECT_THAT(std::string(ExtractTraversableMap(free).status().message()),
              HasSubstr("no occupied voxel"));
}

TEST(Traversability, OptionsOutOfRangeAreNamed) {
  TraversabilityOptions options;
  EXPECT_TRUE(options.Validate().ok());
  EXPECT_TRUE(TraversabilityOptions::For(core::RobotModel()).Validate().ok());
  options.max_slope_rad = std::nan("");
  EXPECT_THAT(std::string(options.Validate().message()),
              HasSubstr("max_slope_rad is"));
  options = {};
  options.robot_height_m = 0;
  EXPECT_THAT(std::string(options.Validate().message()),
              HasSubstr("robot_height_m"));
}

}  // namespace
}  // namespace treeline::traversability
