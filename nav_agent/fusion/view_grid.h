// Which voxels one view saw occupied, and which it looked through.
#ifndef NAV_AGENT_FUSION_VIEW_GRID_H_
#define NAV_AGENT_FUSION_VIEW_GRID_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/geometry/vector3.h"
#include "nav_agent/octomap/voxel_map.h"

namespace treeline::fusion {

// A box of voxels, two bits each, so that a voxel is counted once however many
// rays pass: a view of a room takes some hundred kilobytes, which stay in the
// processor's cache. Its borders are those of blocks of 8 x 8 x 8 voxels.
//
// Places here are in voxels: voxel (x, y, z) reaches from (x, y, z) to (x, y,
// z) + 1, and (0, 0, 0) is the box's lowest.
class ViewGrid {
 public:
  static constexpr int kSide = 8;  // of a block

  // Clears it. The box is `blocks` blocks from block `lowest` of the map on;
  // what lay at p there is at p - kSide * lowest here.
  void Reset(octree::VoxelIndex lowest, octree::VoxelIndex blocks);
  // What a box of so many blocks takes.
  static int64_t BytesFor(octree::VoxelIndex blocks);

  octree::VoxelIndex lowest_block() const { return lowest_; }
  octree::VoxelIndex blocks() const { return blocks_; }

  // The place must be inside, at least one voxel from the box's borders.
  // Whether its voxel was not yet marked.
  bool MarkOccupied(geometry::Vec3 place);
  // All voxels that the straight line from one place to the other passes, but
  // not the one it ends in. Both at least one voxel from the box's borders.
  // Amanatides, Woo: "A fast voxel traversal algorithm for ray tracing", 1987.
  void MarkFree(geometry::Vec3 from, geometry::Vec3 to);

  // Eight voxels above one another, the lowest in bit 0: column (x, y) of the
  // box, in its z-th layer of blocks. What is occupied may be free too.
  uint8_t Occupied(int x, int y, int z) const {
    return occupied_[ByteOf(x, y, z)];
  }
  uint8_t Free(int x, int y, int z) const { return free_[ByteOf(x, y, z)]; }

  int64_t bytes() const {
    return static_cast<int64_t>(occupied_.capacity() + free_.capacity());
  }

 private:
  size_t ByteOf(int x, int y, int z) const {
    return (static_cast<size_t>(x) * static_cast<size_t>(blocks_.y * kSide) +
            static_cast<size_t>(y)) *
               static_cast<size_t>(blocks_.z) +
           static_cast<size_t>(z);
  }
  int64_t BitOf(octree::VoxelIndex v) const {
    return int64_t{v.x} * stride_x_ + int64_t{v.y} * stride_y_ + v.z;
  }

  octree::VoxelIndex lowest_;
  octree::VoxelIndex blocks_;
  // From one voxel to the next along an axis, in bits.
  int64_t stride_x_ = 0;
  int64_t stride_y_ = 0;
  std::vector<uint8_t> occupied_;
  std::vector<uint8_t> free_;
};

}  // namespace treeline::fusion

#endif  // NAV_AGENT_FUSION_VIEW_GRID_H_
