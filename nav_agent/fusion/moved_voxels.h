// Which occupied voxels are of what has moved: people, carts, doors.
#ifndef NAV_AGENT_FUSION_MOVED_VOXELS_H_
#define NAV_AGENT_FUSION_MOVED_VOXELS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "common/geometry/vector3.h"
#include "nav_agent/fusion/fusion_options.h"
#include "nav_agent/fusion/occupancy_blocks.h"
#include "nav_agent/fusion/view_grid.h"

namespace treeline::fusion {

// Log-odds forget what moved only where views come after it. This looks at all
// views of an occupied voxel, before and after: in the spirit of Schauer and
// Nuechter, "The Peopleremover", 2018, and of OctoMap's log-odds.
//
// A view *clears* a voxel if it looks through it from near enough to see thin
// things, and through all that lies around and above it within a voxel, and
// meets nothing there. So beams that pass beside a leg, an edge or a wire clear
// nothing, since others of the same view meet it within a voxel, wherever the
// pose's error has put it. What lies below may be met, since things stand on
// floors, but must be seen: a table top that is looked at along its surface
// hides it. A voxel has moved if several views in a row
// clear it, without one between that meets something, and those that clear it
// are many beside those that meet something. What touches such voxels has moved
// with them if it was cleared at all, or was hardly met: the head of somebody
// who walked by, above all that is seen later.
//
// Not thread-safe.
class MovedVoxels {
 public:
  // Of what is occupied in `map` now, which need not outlive this.
  MovedVoxels(const OccupancyBlocks& map, const FusionOptions& options);

  // Adds a view, in their order in time. `eye` is the sensor's place, as in
  // ViewGrid. Views of lines only meet things.
  void Add(const ViewGrid& view, ViewKind kind, geometry::Vec3 eye);

  // Those that are occupied, and have something below them that stays: no hole
  // is made in what may be ground. `map` as above. Numbered as in a VoxelMap
  // whose lowest() is 0; in no order that matters, but always the same.
  std::vector<octree::VoxelIndex> Find(const OccupancyBlocks& map) const;

 private:
  static constexpr int kSide = ViewGrid::kSide;
  static constexpr int kColumns = kSide * kSide;

  struct Votes {
    uint16_t hits = 0;
    uint16_t clears = 0;
    // Views in a row that cleared it: the latest, and the most.
    uint16_t run = 0;
    uint16_t longest_run = 0;
  };
  // Of a block of the map: which voxels were ever met and which of these are
  // occupied (bits as Block::known), and where the votes of a column's lowest
  // are.
  struct Met {
    octree::VoxelIndex at;
    std::array<uint8_t, kColumns> bits{};
    std::array<uint8_t, kColumns> occupied{};
    std::array<uint32_t, kColumns> first_vote{};
  };

  // The votes of a voxel, if it was ever met.
  static constexpr uint32_t kNone = ~uint32_t{0};
  uint32_t VotesOf(octree::VoxelIndex voxel) const;
  // Of a column of `block`: what a view met, and what it cleared.
  void AddHits(const Met& block, size_t column, unsigned hits);
  void AddClears(const Met& block, size_t column, unsigned clears);
  bool IsSeed(const Votes& votes) const;
  bool MayBelong(const Votes& votes) const;
  int CountMovedAround(octree::VoxelIndex voxel,
                       const std::vector<bool>& moved) const;
  // Adds what touches voxels that have moved and was cleared; then what touches
  // these and was hardly met. By votes: whether it has moved, and the voxels in
  // the order of their finding.
  void Spread(std::vector<bool>& moved,
              std::vector<octree::VoxelIndex>& found) const;
  void AddGlimpses(std::vector<bool>& moved,
                   std::vector<octree::VoxelIndex>& found) const;
  // Something below it stays, and all between is known.
  bool IsAboveGround(octree::VoxelIndex voxel, const std::vector<bool>& moved,
                     const OccupancyBlocks& map) const;
  bool IsOccupied(octree::VoxelIndex voxel) const;

  double reach_;  // voxels
  int min_run_;
  double min_share_;
  double min_share_beside_;
  int max_glimpses_;
  std::vector<Met> blocks_;
  absl::flat_hash_map<uint64_t, size_t> block_of_key_;
  std::vector<Votes> votes_;
};

}  // namespace treeline::fusion

#endif  // NAV_AGENT_FUSION_MOVED_VOXELS_H_
