// Poses in the plane from what is known of them relative to each other.
#ifndef NAV_AGENT_MAPPING_POSE_GRAPH_H_
#define NAV_AGENT_MAPPING_POSE_GRAPH_H_

#include <limits>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/mapping/scan_matcher.h"

namespace treeline::mapping {

// Pose `to` as seen from pose `from`.
struct PoseConstraint {
  int from = 0;
  int to = 0;
  geometry::Rigid2 from_from_to;
  // Of from_from_to; positive definite.
  Covariance3 covariance{};
  // Whether it may be wrong altogether: it then has a bounded pull.
  bool may_be_wrong = false;
  // How much higher `to` is, and its standard deviation (m); infinite: not
  // known.
  double climb_m = 0;
  double climb_sigma_m = std::numeric_limits<double>::infinity();
};

struct PoseGraphOptions {
  int max_iterations = 30;
  // Constraints that may be wrong are weighed by Cauchy's kernel: beyond this
  // many standard deviations their pull grows no more (above 0).
  double kernel_sigmas = 2.0;
};

// Moves poses 1 and up (pose 0 stays) to the minimum of
//
//   sum_c rho(|S_c^-1/2 (from_from_to_c - from^-1 to)|^2)
//
// with angles taken in [-pi, pi]: Levenberg-Marquardt on sparse normal
// equations (Ceres Solver). Deterministic. INVALID_ARGUMENT for constraints
// that name no poses or are not finite; INTERNAL if the solver fails; the poses
// are then as they were.
absl::Status OptimizePoseGraph(std::span<const PoseConstraint> constraints,
                               const PoseGraphOptions& options,
                               std::vector<geometry::Rigid2>* map_from_poses);

// The same for heights (m), which do not depend on the rest: to the minimum of
//
//   sum_c rho(((to - from) - climb_c)^2 / sigma_c^2)
//
// Height 0 stays as it is. Not for constraints whose climb is not known.
absl::Status OptimizeHeights(std::span<const PoseConstraint> constraints,
                             const PoseGraphOptions& options,
                             std::vector<double>* heights_m);

// |S^-1/2 (from_from_to - from^-1 to)|^2: about 3 for one that holds.
double SquaredError(const PoseConstraint& constraint,
                    std::span<const geometry::Rigid2> map_from_poses);

// The covariance of a_from_b in b's axes instead of a's, or in those of any
// frame turned by yaw_rad against its own: translation parts are turned.
Covariance3 Turned(const Covariance3& covariance, double yaw_rad);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_POSE_GRAPH_H_
