// Traversable maps of synthetic buildings against their ground truth. The long
// form, with more buildings and a depth camera's maps: traversability_worlds.
#include <string>

#include "gtest/gtest.h"
#include "nav_agent/traversability/testing_scene.h"
#include "simulation/worlds/ground_truth.h"
#include "simulation/worlds/world.h"
#include "tests/traversable_worlds/testing_world.h"

namespace treeline {
namespace {

constexpr traversability::VoxelNoise kNoise{
    .seed = 3, .dropped = 0.05, .near = 0.005, .far = 1e-4};

struct Building {
  worlds::World world;
  worlds::GroundTruth truth;
  octree::VoxelMap voxels;
};

Building MakeBuilding(const std::string& name,
                      const traversability::VoxelNoise& noise) {
  worlds::World world = *worlds::MakeWorld(
      name, {.with_people = false, .threads = 1, .paint = false});
  const traversability::TraversabilityOptions options;
  worlds::GroundTruth truth = *worlds::GroundTruth::Compute(
      world, {.resolution_m = 0.05,
              .max_slope_rad = options.max_slope_rad,
              .max_step_m = options.max_step_m,
              .clearance_m = options.robot_height_m});
  octree::VoxelMap voxels =
      traversability::WithNoise(VoxelizeWorld(world), noise);
  return {std::move(world), std::move(truth), std::move(voxels)};
}

void ExpectRight(const Building& building,
                 const traversability::TraversableMap& map) {
  EXPECT_EQ(map.levels.size(), building.truth.levels().size());
  const WorldScore score = ScoreWorld(building.truth, building.voxels, map);
  EXPECT_GT(score.cells, 15000);
  EXPECT_GE(score.RightShare(), 0.99)
      << score.wrong << " of " << score.cells << " cells are wrong";
  EXPECT_EQ(score.free_stairs, 0);
  EXPECT_EQ(score.free_edges, 0);
  // Level floors are known to be, and rooms to a voxel's rounding at each end.
  EXPECT_LE(Quantile(score.slope_errors_deg, 0.5), 0.1);
  EXPECT_LE(Quantile(score.clearance_errors_m, 0.95), 0.1);
  // Ramps of some 5 to 10 degrees: one voxel is about one degree.
  EXPECT_LE(Quantile(score.ramp_slope_errors_deg, 0.5), 0.6);
}

class TraversabilityOfWorlds : public testing::TestWithParam<const char*> {};

TEST_P(TraversabilityOfWorlds, CellsAreRightAndStairsAndEdgesNeverFree) {
  const Building building =
      MakeBuilding(GetParam(), traversability::VoxelNoise());
  const absl::StatusOr<traversability::TraversableMap> map =
      traversability::ExtractTraversableMap(building.voxels);
  ASSERT_TRUE(map.ok()) << map.status();
  ExpectRight(building, *map);
}

TEST_P(TraversabilityOfWorlds, CellsAreRightWithVoxelNoise) {
  const Building building = MakeBuilding(GetParam(), kNoise);
  const absl::StatusOr<traversability::TraversableMap> map =
      traversability::ExtractTraversableMap(building.voxels);
  ASSERT_TRUE(map.ok()) << map.status();
  ExpectRight(building, *map);
}

INSTANTIATE_TEST_SUITE_P(Buildings, TraversabilityOfWorlds,
                         testing::Values("cafe", "lab", "seed:1", "seed:3"));

TEST(TraversabilityOfTwoStoreys, AreTwoLevelsJoinedByTheRamp) {
  const Building building = MakeBuilding("two-storey", kNoise);
  const absl::StatusOr<traversability::TraversableMap> map =
      traversability::ExtractTraversableMap(building.voxels);
  ASSERT_TRUE(map.ok()) << map.status();
  ExpectRight(building, *map);
  ASSERT_EQ(map->joins.size(), 1u);
  // As wide as the ramp, and no floor besides.
  EXPECT_GE(map->joins[0].cells.size(), 20u);
  EXPECT_LE(map->joins[0].cells.size(), 3000u);
}

}  // namespace
}  // namespace treeline
