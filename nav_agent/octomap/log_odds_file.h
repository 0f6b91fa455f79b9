// An .ot file with probabilities, not only free and occupied.
#ifndef NAV_AGENT_OCTOMAP_LOG_ODDS_FILE_H_
#define NAV_AGENT_OCTOMAP_LOG_ODDS_FILE_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "nav_agent/octomap/voxel_map.h"

namespace treeline::octree {

// 8 x 8 x 8 voxels; voxel (x, y, z) of block (X, Y, Z) is voxel (8 X + x, 8 Y +
// y, 8 Z + z) of a VoxelMap whose lowest() is 0.
struct LogOddsBlock {
  static constexpr int kSide = 8;
  // Log-odds of voxel (x, y, z) at 64 x + 8 y + z.
  std::span<const float, kSide * kSide * kSide> log_odds;
  // Whether it is known: bit z of byte 8 x + y.
  std::span<const uint8_t, kSide * kSide> known;
};

// The pruned tree as OctoMap writes it: cubes of equal log-odds are one leaf,
// and inner nodes are as occupied as their most occupied child. `find` gives
// the blocks from `lowest` to before `end`; nullopt: nothing is known there.
// INVALID_ARGUMENT for a resolution that is not positive, or blocks further
// than 2^15 voxels from the origin.
absl::StatusOr<std::string> FormatLogOddsOt(
    double resolution_m, VoxelIndex lowest, VoxelIndex end,
    const std::function<std::optional<LogOddsBlock>(VoxelIndex)>& find);

}  // namespace treeline::octree

#endif  // NAV_AGENT_OCTOMAP_LOG_ODDS_FILE_H_
