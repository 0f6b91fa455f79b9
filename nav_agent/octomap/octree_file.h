// OctoMap's files, .bt and .ot, in and out.
//
// Hornung, Wurm, Bennewitz, Stachniss, Burgard: "OctoMap", Autonomous Robots
// 34 (2013); https://octomap.github.io/octomap/doc/. The library's own reader
// follows a file's word without limits on depth or size, so this one does not
// use it.
#ifndef NAV_AGENT_OCTOMAP_OCTREE_FILE_H_
#define NAV_AGENT_OCTOMAP_OCTREE_FILE_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/octomap/voxel_map.h"

namespace treeline::octree {

struct OctreeReadOptions {
  // A leaf of an .ot file is occupied from this probability on, in (0, 1), and
  // free below (thesis 6.6.1). A .bt file has decided already.
  double occupied_threshold = 0.7;
  // The map in memory; RESOURCE_EXHAUSTED above.
  int64_t max_bytes = VoxelMap::kDefaultMaxBytes;

  absl::Status Validate() const;
};

// A .bt file (id OcTree), or an .ot file (id OcTree or ColorOcTree, whose
// colours are left out). INVALID_ARGUMENT, with `name` in front, for what is
// truncated, too deep, longer or shorter than its head says, or another tree.
// The result is the box of all known voxels; empty for an empty tree. Safe on
// any bytes; memory besides the map is at most a small multiple of them.
absl::StatusOr<VoxelMap> ParseOctree(absl::string_view bytes,
                                     absl::string_view name,
                                     const OctreeReadOptions& options = {});
absl::StatusOr<VoxelMap> ReadOctree(const std::string& path,
                                    const OctreeReadOptions& options = {});

// The pruned tree of `map`, as OctoMap writes it. In an .ot file free and
// occupied have OctoMap's clamping probabilities, 0.1192 and 0.971.
// INVALID_ARGUMENT for voxels further than 2^15 from the origin.
absl::StatusOr<std::string> FormatBt(const VoxelMap& map);
absl::StatusOr<std::string> FormatOt(const VoxelMap& map);

// By the end of the path, .bt or .ot; INVALID_ARGUMENT for any other. Replaced
// atomically.
absl::Status WriteOctree(const VoxelMap& map, const std::string& path);

}  // namespace treeline::octree

#endif  // NAV_AGENT_OCTOMAP_OCTREE_FILE_H_
