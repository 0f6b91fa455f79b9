#include "nav_agent/fusion/moved_voxels.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace treeline::fusion {
namespace {

void CountUp(uint16_t& count) {
  if (count < std::numeric_limits<uint16_t>::max()) ++count;
}

// Of eight voxels above one another: whether a view passes through that voxel
// and all around it in its own layer.
struct Around {
  unsigned open = 0;  // and meets nothing in any
  unsigned seen = 0;  // or meets something
};
Around LookAround(const ViewGrid& view, int x, int y, int z) {
  const octree::VoxelIndex blocks = view.blocks();
  if (x < 1 || y < 1 || z < 0 || x + 1 >= blocks.x * ViewGrid::kSide ||
      y + 1 >= blocks.y * ViewGrid::kSide || z >= blocks.z) {
    return {};
  }
  Around around{.open = 0xff, .seen = 0xff};
  for (int next_x = x - 1; next_x <= x + 1 && around.seen != 0; ++next_x) {
    for (int next_y = y - 1; next_y <= y + 1 && around.seen != 0; ++next_y) {
      const unsigned free = view.Free(next_x, next_y, z);
      const unsigned occupied = view.Occupied(next_x, next_y, z);
      around.open &= free & ~occupied;
      around.seen &= free | occupied;
    }
  }
  return around;
}

template <typename Visit>
void ForEachAround(octree::VoxelIndex at, const Visit& visit) {
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dz = -1; dz <= 1; ++dz) {
        if (dx == 0 && dy == 0 && dz == 0) continue;
        visit(octree::VoxelIndex{at.x + dx, at.y + dy, at.z + dz});
      }
    }
  }
}

// How many of the voxels around one have to have moved, for one that was
// cleared and for one that was hardly met.
constexpr int kMinAroundCleared = 2;
constexpr int kMinAroundGlimpse = 3;
// So far below (voxels) the ground is looked for.
constexpr int kMaxHeight = 64;

// Of eight voxels above one another, those below a place.
unsigned Below(size_t z) { return (1U << z) - 1; }

}  // namespace

MovedVoxels::MovedVoxels(const OccupancyBlocks& map,
                         const FusionOptions& options)
    : reach_(options.clearing_range_m / options.resolution_m),
      min_run_(options.min_clearing_views),
      min_share_(options.min_clearing_share),
      min_share_beside_(options.min_clearing_share_beside),
      max_glimpses_(options.max_glimpses) {
  uint32_t votes = 0;
  map.ForEachBlock([&](octree::VoxelIndex at,
                       const OccupancyBlocks::Block& block) {
    Met met{.at = at};
    const uint32_t before = votes;
    for (size_t column = 0; column < kColumns; ++column) {
      met.occupied[column] = map.OccupiedIn(block, column);
      met.bits[column] =
          static_cast<uint8_t>(block.surface[column] | met.occupied[column]);
      met.first_vote[column] = votes;
      votes += static_cast<uint32_t>(std::popcount(met.bits[column]));
    }
    if (votes == before) return;
    block_of_key_[OccupancyBlocks::KeyOf(at)] = blocks_.size();
    blocks_.push_back(met);
  });
  votes_.resize(votes);
}

void MovedVoxels::Add(const ViewGrid& view, ViewKind kind, geometry::Vec3 eye) {
  const octree::VoxelIndex lowest = view.lowest_block();
  const octree::VoxelIndex size = view.blocks();
  const double reach = reach_ * reach_;
  for (const Met& block : blocks_) {
    const octree::VoxelIndex in_view{
        block.at.x - lowest.x, block.at.y - lowest.y, block.at.z - lowest.z};
    if (in_view.x < 0 || in_view.y < 0 || in_view.z < 0 ||
        in_view.x >= size.x || in_view.y >= size.y || in_view.z >= size.z) {
      continue;
    }
    for (size_t column = 0; column < kColumns; ++column) {
      const unsigned met = block.bits[column];
      if (met == 0) continue;
      const int x = in_view.x * kSide + static_cast<int>(column) / kSide;
      const int y = in_view.y * kSide + static_cast<int>(column) % kSide;
      const unsigned hits = view.Occupied(x, y, in_view.z) & met;
      AddHits(block, column, hits);
      if (kind == ViewKind::kLines) continue;
      const Around here = LookAround(view, x, y, in_view.z);
      if ((here.open & met) == 0) continue;
      const Around below = LookAround(view, x, y, in_view.z - 1);
      const Around above = LookAround(view, x, y, in_view.z + 1);
      unsigned clears = met & here.open &
                        (here.open >> 1 | (above.open & 1) << 7) &
                        (here.seen << 1 | below.seen >> 7);
      for (unsigned bits = clears; bits != 0; bits &= bits - 1) {
        const int z = std::countr_zero(bits);
        const geometry::Vec3 middle{x + 0.5, y + 0.5,
                                    in_view.z * kSide + z + 0.5};
        if (geometry::SquaredNorm(middle - eye) > reach) {
          clears &= ~(1U << z);
        }
      }
      AddClears(block, column, clears);
    }
  }
}

void MovedVoxels::AddHits(const Met& block, size_t column, unsigned hits) {
  for (; hits != 0; hits &= hits - 1) {
    const unsigned below =
        block.bits[column] & Below(static_cast<size_t>(std::countr_zero(hits)));
    Votes& votes = votes_[block.first_vote[column] +
                          static_cast<uint32_t>(std::popcount(below))];
    CountUp(votes.hits);
    votes.run = 0;
  }
}

void MovedVoxels::AddClears(const Met& block, size_t column, unsigned clears) {
  for (; clears != 0; clears &= clears - 1) {
    const unsigned below = block.bits[column] &
                           Below(static_cast<size_t>(std::countr_zero(clears)));
    Votes& votes = votes_[block.first_vote[column] +
                          static_cast<uint32_t>(std::popcount(below))];
    CountUp(votes.clears);
    CountUp(votes.run);
    votes.longest_run = std::max(votes.longest_run, votes.run);
  }
}

uint32_t MovedVoxels::VotesOf(octree::VoxelIndex voxel) const {
  // Shifts round down, and masks stay positive, for negative numbers too.
  static_assert(kSide == 8);
  const auto found = block_of_key_.find(
      OccupancyBlocks::KeyOf({voxel.x >> 3, voxel.y >> 3, voxel.z >> 3}));
  if (found == block_of_key_.end()) return kNone;
  const Met& block = blocks_[found->second];
  const auto column =
      static_cast<size_t>((voxel.x & 7) * kSide + (voxel.y & 7));
  const auto z = static_cast<size_t>(voxel.z & 7);
  const unsigned bits = block.bits[column];
  if ((bits >> z & 1) == 0) return kNone;
  return block.first_vote[column] +
         static_cast<uint32_t>(std::popcount(bits & Below(z)));
}

bool MovedVoxels::IsSeed(const Votes& votes) const {
  return votes.longest_run >= min_run_ &&
         votes.clears >= min_share_ * votes.hits;
}

bool MovedVoxels::MayBelong(const Votes& votes) const {
  return votes.clears > 0 && votes.clears >= min_share_beside_ * votes.hits;
}

bool MovedVoxels::IsOccupied(octree::VoxelIndex voxel) const {
  const auto found = block_of_key_.find(
      OccupancyBlocks::KeyOf({voxel.x >> 3, voxel.y >> 3, voxel.z >> 3}));
  if (found == block_of_key_.end()) return false;
  const auto column =
      static_cast<size_t>((voxel.x & 7) * kSide + (voxel.y & 7));
  return (blocks_[found->second].occupied[column] >> (voxel.z & 7) & 1) != 0;
}

std::vector<octree::VoxelIndex> MovedVoxels::Find(
    const OccupancyBlocks& map) const {
  std::vector<bool> moved(votes_.size(), false);
  std::vector<octree::VoxelIndex> found;
  for (const Met& block : blocks_) {
    for (size_t column = 0; column < kColumns; ++column) {
      size_t vote = block.first_vote[column];
      for (unsigned bits = block.bits[column]; bits != 0; bits &= bits - 1) {
        moved[vote] = IsSeed(votes_[vote]);
        if (moved[vote]) {
          found.push_back(
              {block.at.x * kSide + static_cast<int>(column) / kSide,
               block.at.y * kSide + static_cast<int>(column) % kSide,
               block.at.z * kSide + std::countr_zero(bits)});
        }
        ++vote;
      }
    }
  }
  Spread(moved, found);
  AddGlimpses(moved, found);
  std::erase_if(found, [&](octree::VoxelIndex voxel) {
    return !IsOccupied(voxel) || !IsAboveGround(voxel, moved, map);
  });
  return found;
}

int MovedVoxels::CountMovedAround(octree::VoxelIndex voxel,
                                  const std::vector<bool>& moved) const {
  int around = 0;
  ForEachAround(voxel, [&](octree::VoxelIndex next) {
    const uint32_t vote = VotesOf(next);
    around += vote != kNone && moved[vote];
  });
  return around;
}

void MovedVoxels::Spread(std::vector<bool>& moved,
                         std::vector<octree::VoxelIndex>& found) const {
  for (size_t i = 0; i < found.size(); ++i) {
    ForEachAround(found[i], [&](octree::VoxelIndex next) {
      if (!IsOccupied(next)) return;
      const uint32_t vote = VotesOf(next);
      if (moved[vote] || !MayBelong(votes_[vote])) return;
      if (CountMovedAround(next, moved) < kMinAroundCleared) return;
      moved[vote] = true;
      found.push_back(next);
    });
  }
}

void MovedVoxels::AddGlimpses(std::vector<bool>& moved,
                              std::vector<octree::VoxelIndex>& found) const {
  const std::vector<bool> cleared = moved;
  const size_t count = found.size();
  for (size_t i = 0; i < count; ++i) {
    ForEachAround(found[i], [&](octree::VoxelIndex next) {
      const uint32_t vote = VotesOf(next);
      if (vote == kNone || moved[vote]) return;
      const Votes& votes = votes_[vote];
      if (votes.clears > 0 || votes.hits > max_glimpses_) return;
      if (CountMovedAround(next, cleared) < kMinAroundGlimpse) return;
      moved[vote] = true;
      found.push_back(next);
    });
  }
}

bool MovedVoxels::IsAboveGround(octree::VoxelIndex voxel,
                                const std::vector<bool>& moved,
                                const OccupancyBlocks& map) const {
  for (int below = 1; below <= kMaxHeight; ++below) {
    const octree::VoxelIndex at{voxel.x, voxel.y, voxel.z - below};
    if (IsOccupied(at) && !moved[VotesOf(at)]) return true;
    if (!map.IsKnown(at)) return false;
  }
  return false;
}

}  // namespace treeline::fusion
