// Pose hypotheses from 3-point samples, and their preemptive pruning.
#ifndef SERVER_CORE_POSE_PREEMPTIVE_RANSAC_H_
#define SERVER_CORE_POSE_PREEMPTIVE_RANSAC_H_

#include <cstdint>
#include <optional>
#include <stop_token>

#include "common/geometry/rigid3.h"
#include "server/core/pose/rigid_refinement.h"
#include "server/core/pose/scene_predictions.h"

namespace treeline::pose {

struct RansacOptions {
  uint64_t seed = 0;
  int hypotheses = 256;
  // Points scored between two prunings.
  int block = 100;
  // Residuals count in full up to this distance and no further (m).
  double inlier_distance_m = 0.1;
  // The three points of a hypothesis are at least this far apart (m), ...
  double min_side_m = 0.25;
  // ... and the sides of their triangle agree with those of their predictions
  // this well (m).
  double side_tolerance_m = 0.06;
  // Triples drawn for a hypothesis before it is given up.
  int draws = 100;
  // With these, hypotheses are refitted by RefineRigid (thesis 5.5) once no
  // more than `refined` are left, and by Kabsch before; else always by Kabsch,
  // to points alone.
  std::optional<RefinementOptions> refinement;
  int refined = 4;
};

struct RansacResult {
  geometry::Rigid3 world_from_camera;
  // Points whose best prediction lies within inlier_distance_m.
  int inliers = 0;
};

// Preemptive RANSAC (Nister 2003; thesis 4.2.5): all hypotheses are scored on
// a block of points by the truncated squared distance to the points' best
// predictions (of points on lines: from the line); the better half is refitted
// to its inliers so far (Kabsch) and goes on to the next block. Points must be
// in random order. nullopt: no triple was consistent. The same input gives the
// same result.
std::optional<RansacResult> PreemptiveRansac(const ScenePredictions& scene,
                                             const RansacOptions& options,
                                             const std::stop_token& stop);

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_PREEMPTIVE_RANSAC_H_
