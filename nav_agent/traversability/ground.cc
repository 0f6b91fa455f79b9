#include "nav_agent/traversability/ground.h"

#include <algorithm>
#include <cmath>

#include "nav_agent/traversability/ground_links.h"
#include "nav_agent/traversability/ground_stages.h"
#include "nav_agent/traversability/rough_ground.h"

namespace treeline::traversability {
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

// `ground` with the columns of `part.rect` replaced by `part`.
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

namespace {

// Which ground there is in a column, and how it is linked, depends on voxels
// this many columns away: stray voxels 1, rough ground, holes 2, spikes 1,
// links 1.
constexpr int kLinkReach = 5 + kSettleReach;
// Gradients depend on links this far away: the bell 1 + 1 + 2 + 4 + 4 cells,
// level runs 20 + 4.
constexpr int kGradientReach = 24;

// And whether it is narrow: erosion and dilation.
int NarrowReach(const VoxelLimits& limits) { return 2 * limits.erosion + 1; }

ColumnRect BoundsOf(const octree::VoxelMap& voxels) {
  return {.begin_x = 0,
          .begin_y = 0,
          .end_x = voxels.size().x,
          .end_y = voxels.size().y};
}

// The ground of `rect`, linked; no more is known of it.
GroundColumns FindLinkedGround(const octree::VoxelMap& voxels,
                               const VoxelLimits& limits, bool needs_sight,
                               const ColumnRect& rect) {
  const ColumnRect window = rect.Grown(kLinkReach, BoundsOf(voxels));
  const CleanColumns columns(voxels, window);
  GroundColumns ground = FindTops(columns, needs_sight);
  SettleRoughGround(ground);
  // What the first pass closed supports the second.
  ground = FillHoles(columns, std::move(ground));
  ground = FillHoles(columns, std::move(ground));
  LevelSpikes(ground);
  LinkGround(columns, limits, ground);
  return window == rect ? std::move(ground) : Cropped(ground, rect);
}

// Calls copy(from, to) for each node of `rect` in `part` and in `ground`, which
// have the same nodes there.
template <typename Copy>
void ForSameNodes(const GroundColumns& part, const ColumnRect& rect,
                  GroundColumns& ground, const Copy& copy) {
  for (int y = rect.begin_y; y < rect.end_y; ++y) {
    for (int x = rect.begin_x; x < rect.end_x; ++x) {
      const auto from = part.At(part.ColumnOf(x, y));
      GroundNode* to =
          ground.nodes.data() + ground.begin[ground.ColumnOf(x, y)];
      for (const GroundNode& node : from) copy(node, *to++);
    }
  }
}

}  // namespace

GroundColumns FindGround(const octree::VoxelMap& voxels,
                         const VoxelLimits& limits, bool needs_sight) {
  GroundColumns ground =
      FindLinkedGround(voxels, limits, needs_sight, BoundsOf(voxels));
  MeasureGradients(ground);
  FindNarrowGround(limits, ground);
  return ground;
}

void UpdateGround(const octree::VoxelMap& voxels, const VoxelLimits& limits,
                  bool needs_sight, const ColumnRect& changed,
                  GroundColumns& ground) {
  const ColumnRect bounds = BoundsOf(voxels);
  const ColumnRect linked = changed.Grown(kLinkReach, bounds);
  if (linked.width() <= 0 || linked.height() <= 0) return;
  ground =
      Spliced(ground, FindLinkedGround(voxels, limits, needs_sight, linked));

  const ColumnRect sloped = linked.Grown(kGradientReach, bounds);
  GroundColumns part = Cropped(ground, sloped.Grown(kGradientReach, bounds));
  MeasureGradients(part);
  ForSameNodes(part, sloped, ground,
               [](const GroundNode& from, GroundNode& to) {
                 to.gradient_x = from.gradient_x;
                 to.gradient_y = from.gradient_y;
               });

  const int reach = NarrowReach(limits);
  const ColumnRect narrowed = linked.Grown(reach, bounds);
  part = Cropped(ground, narrowed.Grown(reach, bounds));
  FindNarrowGround(limits, part);
  ForSameNodes(
      part, narrowed, ground,
      [](const GroundNode& from, GroundNode& to) { to.narrow = from.narrow; });
}

}  // namespace treeline::traversability
