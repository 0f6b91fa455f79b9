// What a laser that drives on a level sees of a map of voxels: for the lost
// verdict and for gating fixes.
#ifndef NAV_AGENT_LOCALIZATION_LASER_VIEWS_H_
#define NAV_AGENT_LOCALIZATION_LASER_VIEWS_H_

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/localization/lost_scan_check.h"
#include "nav_agent/localization/parameters.h"
#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline::localization {

struct LaserViewOptions {
  // Above the ground that the robot stands on (m, 0 to 5).
  double laser_height_m = core::RobotModel().base_from_laser.translation.z;
  // Rays are cast from places this far apart (m, 0.05 to 10), in so many
  // directions (8 to 3600), so far (m, 0.1 to 100).
  double place_m = kViewPlace_m;
  int directions = kViewDirections;
  double range_m = kViewRange_m;
  // A cell is occupied if this share of the rays that get there end there, and
  // opaque from the second on (0 to 1).
  double hit_share = kViewHitShare;
  double opaque_share = kViewOpaqueShare;

  absl::Status Validate() const;
};

// Rays from all over the free ground of a level, level, at the laser's height
// above that ground. They end at voxels that are occupied within one voxel of
// their height. Where all three are, rays are sure to end: the rest (edges of
// platforms, table tops, thin bars) counts as passed for `opaque`. Tops of
// ground that can be driven on, slopes above all, are nobody's obstacle.
// Errors: INVALID_ARGUMENT for options, and for a level that is not there or is
// not of these voxels.
absl::StatusOr<LaserMap> LaserMapOf(
    const octree::VoxelMap& voxels,
    const traversability::TraversableMap& levels, int level,
    const LaserViewOptions& options);

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_LASER_VIEWS_H_
