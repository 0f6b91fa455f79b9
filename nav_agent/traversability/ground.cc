#include "nav_agent/traversability/ground.h"

#include <algorithm>
#include <cmath>

#include "nav_agent/traversability/ground_stages.h"

namespace treeline {
namespace {

// Whole voxels in a length; a length that is a multiple of the voxel but for
// rounding counts in full.
int VoxelsIn(double length_m, double resolution_m) {
  return static_cast<int>(std::floor(length_m / resolution_m + 1e-6));
}

// The columns of `rect` alone.
GroundColumns Cropped(const GroundColumns& ground, const ColumnRect& rect) {
  GroundColumns cropped;
  cropped.rect = rect;
  cropped.begin.reserve(static_cast<size_t>(rect.width()) *
                            static_cast<size_t>(rect.height()) +
                        1);
  for (int y = rect.begin_y; y < rect.end_y; ++y) {
    for (int x = rect.begin_x; x < rect.end_x; ++x) {
      const std::span<const GroundNode> column =
          ground.At(ground.ColumnOf(x, y));
      cropped.nodes.insert(cropped.nodes.end(), column.begin(), column.end());
      cropped.begin.push_back(static_cast<uint32_t>(cropped.nodes.size()));
    }
  }
  return cropped;
}

}  // namespace

VoxelLimits::VoxelLimits(const TraversabilityOptions& options,
                         double resolution_m)
    : step(std::max(1, VoxelsIn(options.max_step_m, resolution_m))),
      riser(std::max(step, VoxelsIn(options.max_riser_m, resolution_m) + 1)),
      robot_height(static_cast<int>(
          std::ceil(options.robot_height_m / resolution_m - 1e-6))),
      erosion(std::max(
          0, VoxelsIn(options.min_ground_width_m / 2, resolution_m) - 1)),
      overlap(VoxelsIn(options.level_overlap_m, resolution_m)) {}

ColumnRect ColumnRect::Grown(int columns, const ColumnRect& bounds) const {
  return {.begin_x = std::max(begin_x - columns, bounds.begin_x),
          .begin_y = std::max(begin_y - columns, bounds.begin_y),
          .end_x = std::min(end_x + columns, bounds.end_x),
          .end_y = std::min(end_y + columns, bounds.end_y)};
}

int GroundReach(const VoxelLimits& limits) {
  // Stray voxels 1, holes 2, spikes 1, links 1; then gradients 1 + 1 + 2 + 4 +
  // 4, level runs 20 + 4, or erosion and dilation.
  return 5 + std::max(24, 2 * limits.erosion + 1);
}

GroundColumns FindGround(const VoxelMap& voxels, const VoxelLimits& limits,
                         bool needs_sight, const ColumnRect& rect) {
  const ColumnRect bounds{.begin_x = 0,
                          .begin_y = 0,
                          .end_x = voxels.size().x,
                          .end_y = voxels.size().y};
  const ColumnRect window = rect.Grown(GroundReach(limits), bounds);
  const CleanColumns columns(voxels, window);
  GroundColumns ground = FindTops(columns, needs_sight);
  // What the first pass closed supports the second.
  ground = FillHoles(columns, std::move(ground));
  ground = FillHoles(columns, std::move(ground));
  LevelSpikes(ground);
  LinkGround(columns, limits, ground);
  MeasureGradients(ground);
  FindNarrowGround(limits, ground);
  return window == rect ? ground : Cropped(ground, rect);
}

GroundColumns Spliced(const GroundColumns& ground, const GroundColumns& part) {
  GroundColumns spliced;
  spliced.rect = ground.rect;
  spliced.begin.reserve(ground.begin.size());
  spliced.nodes.reserve(ground.nodes.size() + part.nodes.size());
  const auto append = [&spliced](const GroundColumns& from, size_t begin,
                                 size_t end) {
    const auto offset = static_cast<uint32_t>(spliced.nodes.size());
    spliced.nodes.insert(spliced.nodes.end(),
                         from.nodes.begin() + from.begin[begin],
                         from.nodes.begin() + from.begin[end]);
    for (size_t i = begin + 1; i <= end; ++i) {
      spliced.begin.push_back(from.begin[i] - from.begin[begin] + offset);
    }
  };
  const ColumnRect& all = ground.rect;
  const ColumnRect& changed = part.rect;
  for (int y = all.begin_y; y < all.end_y; ++y) {
    const size_t row = ground.ColumnOf(all.begin_x, y);
    const size_t row_end = row + static_cast<size_t>(all.width());
    if (y < changed.begin_y || y >= changed.end_y) {
      append(ground, row, row_end);
      continue;
    }
    const size_t part_row = part.ColumnOf(changed.begin_x, y);
    append(ground, row, ground.ColumnOf(changed.begin_x, y));
    append(part, part_row, part_row + static_cast<size_t>(changed.width()));
    append(ground, row + static_cast<size_t>(changed.end_x - all.begin_x),
           row_end);
  }
  return spliced;
}

}  // namespace treeline
