// Traversable maps of synthetic buildings against their ground truth.
#include <algorithm>
#include <cmath>
#include <vector>

#include "common/synthetic/ground_truth.h"
#include "common/synthetic/world.h"
#include "gtest/gtest.h"
#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline {
namespace {

constexpr double kResolution_m = 0.05;
// Floors lie within voxels, not between two.
constexpr float kLift_m = 0.02F;
constexpr int kBelow = 4;

World MakeBuilding(const char* name) {
  WorldOptions options;
  options.paint = false;
  absl::StatusOr<World> world = MakeWorld(name, options);
  EXPECT_TRUE(world.ok()) << world.status();
  return *std::move(world);
}

// Occupied where a surface is.
void AddSurface(const Surface& surface, VoxelMap& voxels) {
  const auto samples = [](float length_m) {
    return static_cast<int>(std::ceil(length_m / kResolution_m * 4)) + 1;
  };
  const int count_u = samples(surface.LengthU());
  const int count_v = samples(surface.LengthV());
  for (int i = 0; i < count_u; ++i) {
    for (int j = 0; j < count_v; ++j) {
      const auto part = [](int k, int count) {
        return (static_cast<float>(k) + 0.5F) / static_cast<float>(count);
      };
      const Float3 point = surface.PointAt(part(i, count_u), part(j, count_v));
      const VoxelIndex v =
          voxels.IndexOf({point.x, point.y, point.z + kLift_m});
      if (voxels.Contains(v)) voxels.Set(v, Voxel::kOccupied);
    }
  }
}

// Free is what space at the tour's start is connected with: what somebody in
// the building can see.
void FloodFree(const World& world, VoxelMap& voxels) {
  const Float3 start = world.tour.front();
  std::vector<VoxelIndex> front = {
      voxels.IndexOf({start.x, start.y, start.z + 0.5})};
  while (!front.empty()) {
    const VoxelIndex v = front.back();
    front.pop_back();
    if (!voxels.Contains(v) || voxels.At(v) != Voxel::kUnknown) continue;
    voxels.Set(v, Voxel::kFree);
    for (const int step : {-1, 1}) {
      front.push_back({v.x + step, v.y, v.z});
      front.push_back({v.x, v.y + step, v.z});
      front.push_back({v.x, v.y, v.z + step});
    }
  }
}

VoxelMap VoxelizeWorld(const World& world, const GroundTruth& truth) {
  const int size_z =
      static_cast<int>(std::ceil(world.size_m.z / kResolution_m)) + 2 * kBelow;
  VoxelMap voxels =
      *VoxelMap::Make(kResolution_m, {.x = 0, .y = 0, .z = -kBelow},
                      {truth.width(), truth.height(), size_z});
  for (const Surface& surface : world.surfaces) AddSurface(surface, voxels);
  FloodFree(world, voxels);
  return voxels;
}

struct WorldScore {
  int cells = 0;
  int wrong = 0;
  int free_stairs = 0;
};

Occupancy OccupancyOf(GroundState state) {
  return state == GroundState::kFree       ? Occupancy::kFree
         : state == GroundState::kOccupied ? Occupancy::kOccupied
                                           : Occupancy::kUnknown;
}

// Cells within a voxel of where the truth changes may be occupied, or what it
// is there.
WorldScore ScoreWorld(const GroundTruth& truth, int true_level,
                      const OccupancyGrid& grid) {
  WorldScore score;
  for (int y = 1; y + 1 < truth.height(); ++y) {
    for (int x = 1; x + 1 < truth.width(); ++x) {
      const GroundCell& cell = truth.at({true_level, x, y});
      if (cell.state == GroundState::kUnknown) continue;
      const Occupancy ours = grid.At({x, y});
      bool same = true;
      bool among = false;
      bool stairs = true;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const GroundCell& near = truth.at({true_level, x + dx, y + dy});
          same = same && near.state == cell.state;
          among = among || OccupancyOf(near.state) == ours;
          stairs = stairs && near.kind == SurfaceKind::kStair;
        }
      }
      ++score.cells;
      const bool right = same ? ours == OccupancyOf(cell.state)
                              : among || ours == Occupancy::kOccupied;
      if (!right) ++score.wrong;
      if (stairs && ours == Occupancy::kFree) ++score.free_stairs;
    }
  }
  return score;
}

TEST(TraversabilityOfWorlds, TheCafeIsRight) {
  const World world = MakeBuilding("cafe");
  TraversabilityOptions options;
  GroundTruthOptions truth_options;
  truth_options.max_slope_rad = options.max_slope_rad;
  truth_options.max_step_m = options.max_step_m;
  truth_options.clearance_m = options.robot_height_m;
  const GroundTruth truth = *GroundTruth::Compute(world, truth_options);
  const VoxelMap voxels = VoxelizeWorld(world, truth);
  const absl::StatusOr<TraversableMap> map =
      ExtractTraversableMap(voxels, options);
  ASSERT_TRUE(map.ok()) << map.status();
  ASSERT_EQ(truth.levels().size(), 1u);
  ASSERT_EQ(map->levels.size(), 1u);
  const WorldScore score = ScoreWorld(truth, 0, map->levels[0].grid);
  EXPECT_GT(score.cells, 20000);
  EXPECT_LE(score.wrong, 0.01 * score.cells)
      << score.wrong << " of " << score.cells << " cells are wrong";
  EXPECT_EQ(score.free_stairs, 0);
}

TEST(TraversabilityOfWorlds, TheTwoStoreysAreTwoJoinedLevels) {
  const World world = MakeBuilding("two-storey");
  const GroundTruth truth = *GroundTruth::Compute(world, GroundTruthOptions());
  const absl::StatusOr<TraversableMap> map =
      ExtractTraversableMap(VoxelizeWorld(world, truth));
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->levels.size(), 2u);
  EXPECT_GE(map->joins.size(), 1u);
}

}  // namespace
}  // namespace treeline
