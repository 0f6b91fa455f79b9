// How depth views become an OctoMap, in numbers.
#ifndef NAV_AGENT_FUSION_FUSION_OPTIONS_H_
#define NAV_AGENT_FUSION_FUSION_OPTIONS_H_

#include <cstdint>

#include "absl/status/status.h"

namespace treeline::fusion {

// Defaults are OctoMap's sensor model (Hornung et al. 2013) and the thesis's
// map (6.3.1 and 6.6.1).
struct FusionOptions {
  // Of a voxel (m), in [0.01, 0.5].
  double resolution_m = 0.05;

  // Of a voxel in which a ray ends, in [0.5, 1), and of one that a ray passes
  // through, in (0, 0.5]; their log-odds are added up.
  double hit_probability = 0.7;
  double miss_probability = 0.4;
  // No voxel is more certain than this: in (0, 0.5) and (0.5, 1). So what has
  // moved is forgotten after a few views.
  double lowest_probability = 0.1192;
  double highest_probability = 0.971;
  // A voxel is occupied from this probability on, in (0, 1).
  double occupied_threshold = 0.7;

  // Depth (m, along the optical axis) that is used: nearer is dropped, and of
  // what is further only the free space up to max_depth_m is. 0 <= min < max
  // <= 20.
  double min_depth_m = 0.3;
  double max_depth_m = 4;
  // The same for points of other sensors, by their distance (m); in (0, 60].
  double max_point_range_m = 10;

  // Cells of so many pixels squared give one point each, in [1, 16]; 0: as many
  // as span 0.6 voxels at max_depth_m.
  int pixel_step = 0;
  // Statistical outlier removal: a point is dropped if its mean distance from
  // its nearest neighbours, so many of the eight around it, divided by its
  // depth, is more than `outlier_deviations` standard deviations above the
  // view's mean. In [0, 8], 0: all points are kept; and in (0, 100].
  int outlier_neighbors = 2;
  double outlier_deviations = 1;

  // What moved (moved_voxels.h). Views clear from this distance on (m), in (0,
  // 20]: cells of depth lie half a voxel apart there. A voxel has moved if so
  // many views in a row clear it, in [1, 1000], and this share, of those that
  // meet something there; the second share where voxels beside have moved. In
  // [0, 100]. What was met so often, and never cleared, goes with what moved
  // beside it; in [0, 1000]. Chosen on drives through cafe, lab and generated
  // worlds.
  double clearing_range_m = 3;
  int min_clearing_views = 2;
  double min_clearing_share = 0.5;
  double min_clearing_share_beside = 0.05;
  int max_glimpses = 3;

  // What map, clouds and working space may take together (bytes), at least
  // 2^20.
  int64_t max_bytes = int64_t{1} << 30;

  // INVALID_ARGUMENT names the field.
  absl::Status Validate() const;
};

}  // namespace treeline::fusion

#endif  // NAV_AGENT_FUSION_FUSION_OPTIONS_H_
