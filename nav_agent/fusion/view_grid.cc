#include "nav_agent/fusion/view_grid.h"

#include <cmath>
#include <cstdlib>
#include <limits>

namespace treeline::fusion {
namespace {

// Places are never negative: truncation is the floor.
octree::VoxelIndex VoxelAt(geometry::Vec3 place) {
  return {static_cast<int>(place.x), static_cast<int>(place.y),
          static_cast<int>(place.z)};
}

// One axis of a line: where it next enters another voxel, and from one such
// place to the next; in parts of the line.
struct Crossings {
  double next = std::numeric_limits<double>::infinity();
  double step = 0;
};

Crossings CrossingsOf(double from, double to, int voxel) {
  const double length = to - from;
  if (length == 0) return {};
  const double border = length > 0 ? voxel + 1 : voxel;
  return {(border - from) / length, 1 / std::abs(length)};
}

}  // namespace

int64_t ViewGrid::BytesFor(octree::VoxelIndex blocks) {
  return int64_t{blocks.x} * blocks.y * blocks.z * (2 * kSide * kSide);
}

void ViewGrid::Reset(octree::VoxelIndex lowest, octree::VoxelIndex blocks) {
  lowest_ = lowest;
  blocks_ = blocks;
  stride_y_ = int64_t{blocks.z} * kSide;
  stride_x_ = stride_y_ * blocks.y * kSide;
  const auto size = static_cast<size_t>(BytesFor(blocks) / 2);
  occupied_.assign(size, 0);
  free_.assign(size, 0);
}

bool ViewGrid::MarkOccupied(geometry::Vec3 place) {
  const int64_t bit = BitOf(VoxelAt(place));
  uint8_t& byte = occupied_[static_cast<size_t>(bit >> 3)];
  const auto mask = static_cast<uint8_t>(1 << (bit & 7));
  const bool is_new = (byte & mask) == 0;
  byte |= mask;
  return is_new;
}

void ViewGrid::MarkFree(geometry::Vec3 from, geometry::Vec3 to) {
  const octree::VoxelIndex first = VoxelAt(from);
  const octree::VoxelIndex last = VoxelAt(to);
  // So many borders are crossed. Rounding may cross one of another axis at the
  // very end, hence the voxel that the box has to spare.
  const int steps = std::abs(last.x - first.x) + std::abs(last.y - first.y) +
                    std::abs(last.z - first.z);
  Crossings x = CrossingsOf(from.x, to.x, first.x);
  Crossings y = CrossingsOf(from.y, to.y, first.y);
  Crossings z = CrossingsOf(from.z, to.z, first.z);
  const int64_t step_x = to.x > from.x ? stride_x_ : -stride_x_;
  const int64_t step_y = to.y > from.y ? stride_y_ : -stride_y_;
  const int64_t step_z = to.z > from.z ? 1 : -1;
  int64_t bit = BitOf(first);
  uint8_t* const bytes = free_.data();
  for (int i = 0; i < steps; ++i) {
    bytes[bit >> 3] |= static_cast<uint8_t>(1 << (bit & 7));
    if (x.next < y.next) {
      if (x.next < z.next) {
        x.next += x.step;
        bit += step_x;
        continue;
      }
    } else if (y.next < z.next) {
      y.next += y.step;
      bit += step_y;
      continue;
    }
    z.next += z.step;
    bit += step_z;
  }
}

}  // namespace treeline::fusion
