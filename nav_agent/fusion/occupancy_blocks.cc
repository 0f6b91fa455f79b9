#include "nav_agent/fusion/occupancy_blocks.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::fusion {
namespace {

// As octomap computes it, in float.
float LogOdds(double probability) {
  return static_cast<float>(std::log(probability / (1 - probability)));
}

// Calls visit(index of the block in the grid, x, y, byte z) for all columns of
// all blocks.
template <typename Visit>
void ForEachByte(const ViewGrid& view, const Visit& visit) {
  const octree::VoxelIndex blocks = view.blocks();
  for (int x = 0; x < blocks.x * ViewGrid::kSide; ++x) {
    for (int y = 0; y < blocks.y * ViewGrid::kSide; ++y) {
      const auto first = (static_cast<size_t>(x / ViewGrid::kSide) *
                              static_cast<size_t>(blocks.y) +
                          static_cast<size_t>(y / ViewGrid::kSide)) *
                         static_cast<size_t>(blocks.z);
      for (int z = 0; z < blocks.z; ++z) {
        visit(first + static_cast<size_t>(z), x, y, z);
      }
    }
  }
}

}  // namespace

std::optional<ColumnBox> Union(const std::optional<ColumnBox>& a,
                               const std::optional<ColumnBox>& b) {
  if (!a) return b;
  if (!b) return a;
  return ColumnBox{.begin_x = std::min(a->begin_x, b->begin_x),
                   .begin_y = std::min(a->begin_y, b->begin_y),
                   .end_x = std::max(a->end_x, b->end_x),
                   .end_y = std::max(a->end_y, b->end_y)};
}

OccupancyBlocks::OccupancyBlocks(const FusionOptions& options)
    : hit_(LogOdds(options.hit_probability)),
      miss_(LogOdds(options.miss_probability)),
      lowest_(LogOdds(options.lowest_probability)),
      highest_(LogOdds(options.highest_probability)),
      occupied_(LogOdds(options.occupied_threshold)) {}

uint64_t OccupancyBlocks::KeyOf(octree::VoxelIndex block) {
  constexpr int kBits = 21;
  constexpr uint64_t kMask = (uint64_t{1} << kBits) - 1;
  return (static_cast<uint64_t>(block.x) & kMask) << (2 * kBits) |
         (static_cast<uint64_t>(block.y) & kMask) << kBits |
         (static_cast<uint64_t>(block.z) & kMask);
}

uint8_t OccupancyBlocks::OccupiedIn(const Block& block, size_t column) const {
  const float* const values = block.log_odds.data() + column * kSide;
  unsigned occupied = 0;
  for (int z = 0; z < kSide; ++z) {
    if (values[z] >= occupied_) occupied |= 1U << z;
  }
  return static_cast<uint8_t>(occupied & block.known[column]);
}

bool OccupancyBlocks::IsKnown(octree::VoxelIndex voxel) const {
  const Block* const block = Find({voxel.x >> 3, voxel.y >> 3, voxel.z >> 3});
  if (block == nullptr) return false;
  const int column = (voxel.x & 7) * kSide + (voxel.y & 7);
  return (block->known[static_cast<size_t>(column)] >> (voxel.z & 7) & 1) != 0;
}

void OccupancyBlocks::MakeFree(octree::VoxelIndex voxel) {
  // Shifts round down, and masks stay positive, for negative numbers too.
  static_assert(kSide == 8);
  const auto found =
      blocks_.find(KeyOf({voxel.x >> 3, voxel.y >> 3, voxel.z >> 3}));
  if (found == blocks_.end()) return;
  const int column = (voxel.x & 7) * kSide + (voxel.y & 7);
  Block& block = *found->second;
  block.log_odds[static_cast<size_t>(column * kSide + (voxel.z & 7))] = lowest_;
  uint8_t& known = block.known[static_cast<size_t>(column)];
  known = static_cast<uint8_t>(known | 1U << (voxel.z & 7));
}

const OccupancyBlocks::Block* OccupancyBlocks::Find(
    octree::VoxelIndex block) const {
  const auto found = blocks_.find(KeyOf(block));
  return found == blocks_.end() ? nullptr : found->second.get();
}

absl::Status OccupancyBlocks::Touch(const ViewGrid& view, int64_t max_blocks) {
  const octree::VoxelIndex size = view.blocks();
  const octree::VoxelIndex lowest = view.lowest_block();
  std::vector<uint8_t> wanted(static_cast<size_t>(size.x) *
                              static_cast<size_t>(size.y) *
                              static_cast<size_t>(size.z));
  ForEachByte(view, [&view, &wanted](size_t block, int x, int y, int z) {
    wanted[block] = static_cast<uint8_t>(
        wanted[block] | view.Occupied(x, y, z) | view.Free(x, y, z));
  });

  touched_.assign(wanted.size(), nullptr);
  // Which of `touched_`, and where.
  std::vector<std::pair<size_t, octree::VoxelIndex>> missing;
  size_t i = 0;
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      for (int z = 0; z < size.z; ++z, ++i) {
        if (wanted[i] == 0) continue;
        const octree::VoxelIndex block{lowest.x + x, lowest.y + y,
                                       lowest.z + z};
        const auto found = blocks_.find(KeyOf(block));
        if (found == blocks_.end()) {
          missing.emplace_back(i, block);
        } else {
          touched_[i] = found->second.get();
        }
      }
    }
  }
  const int64_t total = blocks() + static_cast<int64_t>(missing.size());
  if (total > max_blocks) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the map would grow to ", total, " blocks of ",
                     kBlockBytes, " bytes; there is room for ", max_blocks));
  }
  for (const auto& [place, block] : missing) touched_[place] = Make(block);
  return absl::OkStatus();
}

OccupancyBlocks::Block* OccupancyBlocks::Make(octree::VoxelIndex block) {
  if (blocks_.empty()) {
    low_ = block;
    high_ = block;
  }
  low_ = {std::min(low_.x, block.x), std::min(low_.y, block.y),
          std::min(low_.z, block.z)};
  high_ = {std::max(high_.x, block.x + 1), std::max(high_.y, block.y + 1),
           std::max(high_.z, block.z + 1)};
  std::unique_ptr<Block>& made = blocks_[KeyOf(block)];
  made = std::make_unique<Block>();
  return made.get();
}

absl::StatusOr<std::optional<ColumnBox>> OccupancyBlocks::Add(
    const ViewGrid& view, ViewKind kind, int64_t max_blocks) {
  TL_RETURN_IF_ERROR(Touch(view, max_blocks));
  const octree::VoxelIndex lowest = view.lowest_block();
  std::optional<ColumnBox> changed;
  ForEachByte(view, [&](size_t block, int x, int y, int z) {
    const uint8_t occupied = view.Occupied(x, y, z);
    uint8_t free = view.Free(x, y, z);
    if ((occupied | free) == 0) return;
    const auto column = static_cast<size_t>(x % kSide * kSide + y % kSide);
    uint8_t& surface = touched_[block]->surface[column];
    if (kind == ViewKind::kSurfaces) {
      surface |= occupied;
    } else {
      free = static_cast<uint8_t>(free & ~surface);
    }
    if (!Update(*touched_[block], column, occupied, free)) return;
    const int map_x = lowest.x * kSide + x;
    const int map_y = lowest.y * kSide + y;
    changed = Union(changed, ColumnBox{map_x, map_y, map_x + 1, map_y + 1});
  });
  return changed;
}

bool OccupancyBlocks::Update(Block& block, size_t column, uint8_t occupied,
                             uint8_t free) {
  float* const values = block.log_odds.data() + column * kSide;
  uint8_t& known = block.known[column];
  bool changed = (~known & (occupied | free)) != 0;
  for (unsigned bits = occupied; bits != 0; bits &= bits - 1) {
    float& value = values[std::countr_zero(bits)];
    const bool was_occupied = value >= occupied_;
    value = std::min(value + hit_, highest_);
    changed = changed || was_occupied != (value >= occupied_);
  }
  for (unsigned bits = free & ~unsigned{occupied}; bits != 0;
       bits &= bits - 1) {
    float& value = values[std::countr_zero(bits)];
    const bool was_occupied = value >= occupied_;
    value = std::max(value + miss_, lowest_);
    changed = changed || was_occupied != (value >= occupied_);
  }
  known = static_cast<uint8_t>(known | occupied | free);
  return changed;
}

}  // namespace treeline::fusion
