#include "nav_agent/fusion/wheel_strip.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "common/geometry/vector3.h"

namespace treeline::fusion {
namespace {

// How far from a hole its edges are bent by what made it (m).
constexpr double kBesideHole_m = 0.3;
// Wheels that are this near to each other in height stood on the same ground,
// and nothing that is as near above them was there (voxels).
constexpr int kSameGround = 3;

// How high the wheels stood in the columns of a map.
class Strip {
 public:
  explicit Strip(const octree::VoxelMap& map) : map_(&map) {}

  void Add(geometry::Vec3 wheel_in_map) {
    const octree::VoxelIndex at = map_->IndexOf(wheel_in_map);
    if (!map_->Contains(at)) return;
    std::vector<Ground>& grounds = columns_[{at.x, at.y}];
    for (Ground& ground : grounds) {
      if (std::abs(ground.Height_m() - wheel_in_map.z) <
          kSameGround * map_->resolution_m()) {
        ground.sum_m += wheel_in_map.z;
        ++ground.count;
        return;
      }
    }
    grounds.push_back({.sum_m = wheel_in_map.z, .count = 1});
  }

  // The voxels of the strip, a column's on each storey.
  std::vector<octree::VoxelIndex> Voxels() const {
    std::vector<octree::VoxelIndex> voxels;
    for (const auto& [column, grounds] : columns_) {
      for (const Ground& ground : grounds) {
        voxels.push_back({column.first, column.second, ZOf(ground)});
      }
    }
    return voxels;
  }

  // Those that are up to `reach` columns from one of them, on the same ground.
  void AddAround(octree::VoxelIndex middle, int reach,
                 std::vector<octree::VoxelIndex>& voxels) const {
    for (int y = middle.y - reach; y <= middle.y + reach; ++y) {
      for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
        const auto column = columns_.find({x, y});
        if (column == columns_.end()) continue;
        for (const Ground& ground : column->second) {
          const int z = ZOf(ground);
          if (std::abs(z - middle.z) <= kSameGround)
            voxels.push_back({x, y, z});
        }
      }
    }
  }

 private:
  struct Ground {
    double sum_m = 0;
    int count = 0;

    double Height_m() const { return sum_m / count; }
  };

  int ZOf(const Ground& ground) const {
    return map_->IndexOf({0, 0, ground.Height_m()}).z;
  }

  const octree::VoxelMap* map_;
  absl::flat_hash_map<std::pair<int, int>, std::vector<Ground>> columns_;
};

bool IsHole(const octree::VoxelMap& map, octree::VoxelIndex at) {
  for (int z = at.z - 1; z <= at.z + 1; ++z) {
    if (map.At({at.x, at.y, z}) == octree::Voxel::kOccupied) return false;
  }
  return true;
}

}  // namespace

int FillWheelStrip(std::span<const geometry::Rigid3> map_from_base,
                   double half_width_m, octree::VoxelMap& map) {
  Strip strip(map);
  // Points at most half a voxel apart.
  const int steps =
      static_cast<int>(std::ceil(2 * half_width_m / map.resolution_m()));
  for (const geometry::Rigid3& pose : map_from_base) {
    for (int i = -steps; i <= steps; ++i) {
      strip.Add(pose *
                geometry::Vec3{0, half_width_m * i / std::max(1, steps), 0});
    }
  }
  int holes = 0;
  const int reach = static_cast<int>(kBesideHole_m / map.resolution_m());
  std::vector<octree::VoxelIndex> put;
  for (const octree::VoxelIndex& at : strip.Voxels()) {
    if (!IsHole(map, at)) continue;
    ++holes;
    strip.AddAround(at, reach, put);
  }
  for (const octree::VoxelIndex& at : put) {
    map.Set(at, octree::Voxel::kOccupied);
    const int top = std::min(at.z + 1 + kSameGround, map.size().z);
    map.SetRun(at.x, at.y, at.z + 1, top, octree::Voxel::kFree);
  }
  return holes;
}

}  // namespace treeline::fusion
