// Log-odds of occupancy, where anything is known.
#ifndef NAV_AGENT_FUSION_OCCUPANCY_BLOCKS_H_
#define NAV_AGENT_FUSION_OCCUPANCY_BLOCKS_H_

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/fusion/fusion_options.h"
#include "nav_agent/fusion/view_grid.h"
#include "nav_agent/octomap/voxel_map.h"

namespace treeline::fusion {

// Columns [begin_x, end_x) x [begin_y, end_y), numbered as VoxelIndex is in a
// VoxelMap whose lowest() is 0.
struct ColumnBox {
  int begin_x = 0;
  int begin_y = 0;
  int end_x = 0;
  int end_y = 0;

  constexpr bool operator==(const ColumnBox&) const = default;
};

// The smallest box that holds both.
std::optional<ColumnBox> Union(const std::optional<ColumnBox>& a,
                               const std::optional<ColumnBox>& b);

// What a view's rays are: those of a depth picture, side by side, or the few of
// a laser's plane. Such a plane may pass just above a floor, through the upper
// part of its voxels: that it met nothing there does not say that they are
// free.
enum class ViewKind : uint8_t { kSurfaces, kLines };

// OctoMap's update (Hornung et al. 2013, Eq. 2 and 4) over blocks of 8 x 8 x 8
// voxels in a hash table. A plain value but for its blocks; not thread-safe.
class OccupancyBlocks {
 public:
  static constexpr int kSide = ViewGrid::kSide;

  struct Block {
    // Voxel (x, y, z) of the block is entry 64 x + 8 y + z.
    std::array<float, kSide * kSide * kSide> log_odds{};
    // Bit z of byte 8 x + y: whether anything is known of that voxel.
    std::array<uint8_t, kSide * kSide> known{};
    // The same: whether a view of surfaces has hit it.
    std::array<uint8_t, kSide * kSide> surface{};
  };

  explicit OccupancyBlocks(const FusionOptions& options);

  // Adds a miss to each voxel that is free in `view` and a hit to each that is
  // occupied, which wins. Misses of kLines do not count where kSurfaces have
  // hit. RESOURCE_EXHAUSTED, and nothing is changed, if there would be more
  // than max_blocks. Returns the columns in which a voxel has become known,
  // occupied or free.
  absl::StatusOr<std::optional<ColumnBox>> Add(const ViewGrid& view,
                                               ViewKind kind,
                                               int64_t max_blocks);

  // Null where nothing is known.
  const Block* Find(octree::VoxelIndex block) const;

  // Bits as in Block::known: which voxels of a column are occupied.
  uint8_t OccupiedIn(const Block& block, size_t column) const;
  // visit(where, block) for each, along z, then y, then x.
  template <typename Visit>
  void ForEachBlock(const Visit& visit) const {
    for (int x = low_.x; x < high_.x; ++x) {
      for (int y = low_.y; y < high_.y; ++y) {
        for (int z = low_.z; z < high_.z; ++z) {
          const Block* const block = Find({x, y, z});
          if (block != nullptr) visit(octree::VoxelIndex{x, y, z}, *block);
        }
      }
    }
  }
  // Numbered as in a VoxelMap whose lowest() is 0.
  bool IsKnown(octree::VoxelIndex voxel) const;
  // As free as can be; a voxel of a known block, numbered as in a VoxelMap
  // whose lowest() is 0.
  void MakeFree(octree::VoxelIndex voxel);

  // Of a block; each coordinate has 21 bits.
  static uint64_t KeyOf(octree::VoxelIndex block);

  // The voxels in known blocks; the box's borders are those of blocks.
  octree::VoxelIndex lowest_block() const { return low_; }
  octree::VoxelIndex end_block() const { return high_; }
  int64_t blocks() const { return static_cast<int64_t>(blocks_.size()); }

  float occupied_log_odds() const { return occupied_; }
  // What a block takes, its share of the table included.
  static constexpr int64_t kBlockBytes = sizeof(Block) + 48;

 private:
  // Fills touched_; makes the blocks that are not there, or none.
  absl::Status Touch(const ViewGrid& view, int64_t max_blocks);
  Block* Make(octree::VoxelIndex block);
  // What becomes of eight voxels. Whether one of them has changed its state.
  bool Update(Block& block, size_t column, uint8_t occupied, uint8_t free);

  float hit_;
  float miss_;
  float lowest_;
  float highest_;
  float occupied_;
  absl::flat_hash_map<uint64_t, std::unique_ptr<Block>> blocks_;
  // The box of all blocks.
  octree::VoxelIndex low_;
  octree::VoxelIndex high_;
  // Of the view that is being added: a block for each of the grid's.
  std::vector<Block*> touched_;
};

}  // namespace treeline::fusion

#endif  // NAV_AGENT_FUSION_OCCUPANCY_BLOCKS_H_
