// Keyframes and landmarks moved to where all sightings agree best.
#ifndef NAV_AGENT_RGBD_SLAM_BUNDLE_ADJUSTMENT_H_
#define NAV_AGENT_RGBD_SLAM_BUNDLE_ADJUSTMENT_H_

#include <span>
#include <vector>

#include "nav_agent/rgbd_slam/slam_map.h"

namespace treeline::rgbd_slam {

struct BundleOptions {
  // Keyframes that move, in [1, 100], and that hold them, in [1, 100].
  int window = 8;
  int fixed = 8;
  // Landmarks at most: those with the most sightings. In [10, 100000].
  int landmarks = 800;
  // In [1, 100].
  int iterations = 4;

  absl::Status Validate() const;
};

// Minimises, over the poses of `keyframe` and of those that share the most
// landmarks with it, and over their landmarks,
//
//   sum huber(|pixel error / sigma|^2 + (depth error / sigma)^2)
//
// (Levenberg-Marquardt with the Schur complement, Ceres Solver), while other
// keyframes that see these landmarks stay; then forgets sightings that do not
// agree. The work is bounded by the options. Deterministic.
void AdjustLocally(int keyframe, const BundleOptions& options, SlamMap* map);

// The same of all keyframes of a submap but its first, which stays; of the
// options only `landmarks` and `iterations` bound it.
void AdjustSubmap(int submap, const BundleOptions& options, SlamMap* map);

// Moves all keyframes of `submap` but the first of them so that the relative
// poses of `edges` hold best; loops are weighed by Huber's kernel. Landmarks
// move with their keyframes.
void OptimizeKeyframes(std::span<const KeyframeEdge> edges,
                       std::span<const KeyframeEdge> loops, int submap,
                       int max_iterations, SlamMap* map);

}  // namespace treeline::rgbd_slam

#endif  // NAV_AGENT_RGBD_SLAM_BUNDLE_ADJUSTMENT_H_
