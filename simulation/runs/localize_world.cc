#include "simulation/runs/localize_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "simulation/worlds/ground_columns.h"

namespace treeline::runs {
namespace {

// A level surface between two voxels belongs to the lower one.
constexpr double kBelow_m = 1e-3;
// Where a robot's laser is, about: free, if the robot can stand there.
constexpr double kAboveGround_m = 0.35;

struct VoxelSpan {
  int begin = 0;
  int end = 0;
};

VoxelSpan SpanOf(const worlds::ColumnSpan& span, double resolution_m) {
  const auto voxel = [resolution_m](double height_m) {
    return static_cast<int>(std::floor((height_m - kBelow_m) / resolution_m));
  };
  return {.begin = voxel(span.low_m), .end = voxel(span.high_m) + 1};
}

// All that can be got to from `begin` through neither occupied voxels nor
// `blocked` ones becomes free.
void Flood(std::vector<octree::VoxelIndex> open,
           const octree::VoxelMap& blocked, octree::VoxelMap& voxels) {
  constexpr std::array<octree::VoxelIndex, 6> kSides = {
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
  while (!open.empty()) {
    const octree::VoxelIndex at = open.back();
    open.pop_back();
    if (!voxels.Contains(at) || voxels.At(at) != octree::Voxel::kUnknown ||
        blocked.At(at) == octree::Voxel::kOccupied) {
      continue;
    }
    voxels.Set(at, octree::Voxel::kFree);
    for (const octree::VoxelIndex& side : kSides) {
      open.push_back({at.x + side.x, at.y + side.y, at.z + side.z});
    }
  }
}

}  // namespace

absl::StatusOr<octree::VoxelMap> VoxelsOfWorld(const worlds::World& world,
                                               double resolution_m) {
  if (world.tour.empty() || world.surfaces.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("world ", world.name,
                     " has no tour for a robot; rooms are for cameras held by "
                     "hand, and a world file needs 'tour' "
                     "(docs/reference/world-files.md)"));
  }
  const int width = static_cast<int>(std::ceil(world.size_m.x / resolution_m));
  const int height = static_cast<int>(std::ceil(world.size_m.y / resolution_m));
  const worlds::GroundColumns columns(world, width, height, resolution_m);
  const size_t cells = static_cast<size_t>(width) * static_cast<size_t>(height);
  VoxelSpan box = {.begin = std::numeric_limits<int>::max(),
                   .end = std::numeric_limits<int>::min()};
  for (size_t cell = 0; cell < cells; ++cell) {
    for (const worlds::ColumnSpan& span : columns.At(cell)) {
      const VoxelSpan voxels = SpanOf(span, resolution_m);
      box.begin = std::min(box.begin, voxels.begin);
      box.end = std::max(box.end, voxels.end);
    }
  }
  const octree::VoxelIndex lowest = {0, 0, box.begin};
  const octree::VoxelIndex size = {width, height, box.end - box.begin};
  TL_ASSIGN_OR_RETURN(octree::VoxelMap voxels,
                      octree::VoxelMap::Make(resolution_m, lowest, size));
  TL_ASSIGN_OR_RETURN(octree::VoxelMap glass,
                      octree::VoxelMap::Make(resolution_m, lowest, size));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const size_t cell = static_cast<size_t>(y) * static_cast<size_t>(width) +
                          static_cast<size_t>(x);
      for (const worlds::ColumnSpan& span : columns.At(cell)) {
        const bool is_glass =
            world.surfaces[span.surface].kind == worlds::SurfaceKind::kGlass;
        const VoxelSpan run = SpanOf(span, resolution_m);
        (is_glass ? glass : voxels)
            .SetRun(x, y, run.begin - box.begin, run.end - box.begin,
                    octree::Voxel::kOccupied);
      }
    }
  }
  std::vector<octree::VoxelIndex> open;
  for (const worlds::Float3& seed : world.tour) {
    open.push_back(voxels.IndexOf({seed.x, seed.y, seed.z + kAboveGround_m}));
  }
  Flood(std::move(open), glass, voxels);
  return voxels;
}

}  // namespace treeline::runs
