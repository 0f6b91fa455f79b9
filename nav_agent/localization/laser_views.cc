#include "nav_agent/localization/laser_views.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "nav_agent/localization/laser_layer.h"
#include "nav_agent/localization/laser_level_map.h"

namespace treeline::localization {
namespace {

struct Votes {
  explicit Votes(size_t cells) : ends(cells), sure(cells), passes(cells) {}
  std::vector<uint32_t> ends;
  std::vector<uint32_t> sure;
  std::vector<uint32_t> passes;
};

// Of the voxels z - 1, z, z + 1 of each column, how many are occupied.
std::vector<uint8_t> OccupiedAround(const octree::VoxelMap& voxels, int z) {
  const octree::VoxelIndex size = voxels.size();
  std::vector<uint8_t> counts;
  counts.reserve(static_cast<size_t>(size.x) * static_cast<size_t>(size.y));
  for (int y = 0; y < size.y; ++y) {
    for (int x = 0; x < size.x; ++x) {
      uint8_t count = 0;
      for (int at = z - 1; at <= z + 1; ++at) {
        if (voxels.At({x, y, at}) == octree::Voxel::kOccupied) ++count;
      }
      counts.push_back(count);
    }
  }
  return counts;
}

class ViewCaster {
 public:
  ViewCaster(const octree::VoxelMap& voxels,
             const traversability::TraversableMap& levels,
             const LaserViewOptions& options, Votes& votes)
      : voxels_(voxels), levels_(levels), options_(options), votes_(votes) {}

  // `from` in cells, from the corner of the box; z: the voxel of the laser.
  void Cast(geometry::Vec2 from, geometry::Vec2 direction, int z) {
    const octree::VoxelIndex size = voxels_.size();
    const std::vector<uint8_t>& counts = CountsAt(z);
    const int steps =
        static_cast<int>(2 * options_.range_m / voxels_.resolution_m());
    core::CellIndex last = {-1, -1};
    for (int step = 1; step <= steps; ++step) {
      const geometry::Vec2 at = from + (0.5 * step) * direction;
      const core::CellIndex cell = {static_cast<int>(std::floor(at.x)),
                                    static_cast<int>(std::floor(at.y))};
      if (cell == last) continue;
      last = cell;
      if (cell.x < 0 || cell.y < 0 || cell.x >= size.x || cell.y >= size.y) {
        return;
      }
      const size_t index =
          static_cast<size_t>(cell.y) * static_cast<size_t>(size.x) +
          static_cast<size_t>(cell.x);
      const uint8_t occupied = counts[index];
      if (occupied == 0) {
        ++votes_.passes[index];
        continue;
      }
      // A slope that the beam meets is no obstacle; whatever lies beyond is
      // not seen from here.
      if (IsTopOfGround(index, z)) return;
      ++votes_.ends[index];
      votes_.sure[index] += occupied == 3 ? 1 : 0;
      return;
    }
  }

 private:
  bool IsTopOfGround(size_t index, int z) const {
    const double height_m =
        (z + voxels_.lowest().z + 0.5) * voxels_.resolution_m();
    return std::ranges::any_of(
        levels_.levels, [&](const traversability::TraversableLevel& level) {
          return level.grid.cells[index] == core::Occupancy::kFree &&
                 std::abs(level.height_m[index] - height_m) <=
                     1.6 * voxels_.resolution_m();
        });
  }

  // Rays of one height ask for the same thousands of times.
  const std::vector<uint8_t>& CountsAt(int z) {
    std::vector<uint8_t>& counts = counts_[z];
    if (counts.empty()) counts = OccupiedAround(voxels_, z);
    return counts;
  }

  const octree::VoxelMap& voxels_;
  const traversability::TraversableMap& levels_;
  const LaserViewOptions& options_;
  Votes& votes_;
  std::map<int, std::vector<uint8_t>> counts_;
};

}  // namespace

absl::Status LaserViewOptions::Validate() const {
  TL_RETURN_IF_ERROR(
      base::CheckRange("laser views: laser_height_m", laser_height_m, 0, 5));
  TL_RETURN_IF_ERROR(
      base::CheckRange("laser views: place_m", place_m, 0.05, 10));
  TL_RETURN_IF_ERROR(
      base::CheckRange("laser views: directions", directions, 8, 3600));
  TL_RETURN_IF_ERROR(
      base::CheckRange("laser views: range_m", range_m, 0.1, 100));
  TL_RETURN_IF_ERROR(
      base::CheckRange("laser views: hit_share", hit_share, 0, 1));
  return base::CheckRange("laser views: opaque_share", opaque_share, 0, 1);
}

absl::StatusOr<LaserMap> LaserMapOf(
    const octree::VoxelMap& voxels,
    const traversability::TraversableMap& levels, int level,
    const LaserViewOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (level < 0 || level >= static_cast<int>(levels.levels.size())) {
    return absl::InvalidArgumentError(absl::StrCat(
        "laser views: no level ", level, "; there are ", levels.levels.size()));
  }
  const traversability::TraversableLevel& own =
      levels.levels[static_cast<size_t>(level)];
  const size_t cells = static_cast<size_t>(voxels.size().x) *
                       static_cast<size_t>(voxels.size().y);
  if (own.grid.width != voxels.size().x || own.grid.height != voxels.size().y ||
      own.height_m.size() != cells) {
    return absl::InvalidArgumentError(
        "laser views: the levels are not of these voxels");
  }
  const double r = voxels.resolution_m();
  Votes votes(cells);
  ViewCaster caster(voxels, levels, options, votes);
  const int every = std::max(1, static_cast<int>(options.place_m / r));
  for (int y = every / 2; y < own.grid.height; y += every) {
    for (int x = every / 2; x < own.grid.width; x += every) {
      if (own.grid.At({x, y}) != core::Occupancy::kFree) continue;
      // height_m is of the middle of the ground's voxel.
      const double laser_m = own.height_m[own.grid.IndexOf({x, y})] + 0.5 * r +
                             options.laser_height_m;
      const int z = LaserLayer(voxels, laser_m);
      for (int i = 0; i < options.directions; ++i) {
        const double angle_rad = 2 * std::numbers::pi * i / options.directions;
        caster.Cast({x + 0.5, y + 0.5},
                    {std::cos(angle_rad), std::sin(angle_rad)}, z);
      }
    }
  }
  LaserMap result;
  result.map = LaserSlice(voxels, own, options.laser_height_m);
  result.opaque = result.map;
  for (size_t i = 0; i < cells; ++i) {
    const uint32_t seen = votes.ends[i] + votes.passes[i];
    if (seen == 0) {
      // No ray gets there; what stands there still explains beams.
      if (result.map.cells[i] == core::Occupancy::kOccupied) {
        result.opaque.cells[i] = core::Occupancy::kUnknown;
      }
      continue;
    }
    result.map.cells[i] = votes.ends[i] >= options.hit_share * seen
                              ? core::Occupancy::kOccupied
                              : core::Occupancy::kFree;
    result.opaque.cells[i] = votes.sure[i] >= options.opaque_share * seen
                                 ? core::Occupancy::kOccupied
                                 : core::Occupancy::kFree;
  }
  return result;
}

}  // namespace treeline::localization
