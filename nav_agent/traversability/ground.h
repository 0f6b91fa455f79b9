// Ground: tops of occupied voxels that something could stand on.
#ifndef NAV_AGENT_TRAVERSABILITY_GROUND_H_
#define NAV_AGENT_TRAVERSABILITY_GROUND_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/traversability_options.h"

namespace treeline::traversability {

// The options in voxels.
struct VoxelLimits {
  VoxelLimits(const TraversabilityOptions& options, double resolution_m);

  int step = 1;   // heights of neighbours that are continuous ground
  int riser = 6;  // a step up, and not a wall, up to here
  int robot_height = 25;
  int erosion = 4;  // ground within this of steps on all sides is narrow
  int overlap = 5;
};

// Columns [begin_x, end_x) x [begin_y, end_y) of a map.
struct ColumnRect {
  int begin_x = 0;
  int begin_y = 0;
  int end_x = 0;
  int end_y = 0;

  bool operator==(const ColumnRect&) const = default;
  int width() const { return end_x - begin_x; }
  int height() const { return end_y - begin_y; }
  bool Contains(int x, int y) const {
    return x >= begin_x && x < end_x && y >= begin_y && y < end_y;
  }
  // Grown each way, but not beyond `bounds`.
  ColumnRect Grown(int columns, const ColumnRect& bounds) const;
};

// The eight neighbours, counter-clockwise from east. Even ones share a side.
struct GridStep {
  int x = 0;
  int y = 0;
};
inline constexpr std::array<GridStep, 8> kNeighbors = {
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
inline constexpr uint8_t kNoLink = 255;

struct GroundNode {
  int32_t z = 0;          // the occupied voxel whose top is the ground
  int32_t clearance = 0;  // voxels above it up to the next occupied one
  // How the ground rises along x and y, in voxels a cell, smoothed over the
  // continuous ground around (sigma about 4 cells).
  float gradient_x = 0;
  float gradient_y = 0;
  // Which ground of each neighbouring column continues this one; kNoLink if
  // none does.
  std::array<uint8_t, 8> link = {kNoLink, kNoLink, kNoLink, kNoLink,
                                 kNoLink, kNoLink, kNoLink, kNoLink};
  bool seen = false;    // space right above it has been observed
  bool edge = false;    // it ends here, and what follows is a drop
  bool step = false;    // beside a drop or a step up
  bool narrow = false;  // too narrow between steps, as a stair's tread is

  bool operator==(const GroundNode&) const = default;
};

inline constexpr int kOpenAbove = 1 << 20;  // clearance if nothing is above

// The ground of all columns of a rectangle, from the bottom up in each: that
// of column (x, y) is nodes[begin[i]] to nodes[begin[i + 1] - 1], where
// i = (y - rect.begin_y) * rect.width() + x - rect.begin_x.
struct GroundColumns {
  ColumnRect rect;
  std::vector<uint32_t> begin = {0};
  std::vector<GroundNode> nodes;

  bool operator==(const GroundColumns&) const = default;
  size_t ColumnOf(int x, int y) const {
    return static_cast<size_t>(y - rect.begin_y) *
               static_cast<size_t>(rect.width()) +
           static_cast<size_t>(x - rect.begin_x);
  }
  std::span<const GroundNode> At(size_t column) const {
    return {nodes.data() + begin[column], begin[column + 1] - begin[column]};
  }
};

// All ground of `voxels`. `needs_sight`: whether only surfaces that were seen
// from above are `seen`; a map without free voxels cannot say.
GroundColumns FindGround(const octree::VoxelMap& voxels,
                         const VoxelLimits& limits, bool needs_sight);

// Makes of the ground before only columns of `changed` did what FindGround
// gives now, bit by bit. The map's size has not changed.
void UpdateGround(const octree::VoxelMap& voxels, const VoxelLimits& limits,
                  bool needs_sight, const ColumnRect& changed,
                  GroundColumns& ground);

}  // namespace treeline::traversability

#endif  // NAV_AGENT_TRAVERSABILITY_GROUND_H_
