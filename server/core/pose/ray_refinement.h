// The last word on a pose from rays: robust, weighted, with a covariance.
#ifndef SERVER_CORE_POSE_RAY_REFINEMENT_H_
#define SERVER_CORE_POSE_RAY_REFINEMENT_H_

#include <optional>

#include "common/geometry/rigid3.h"
#include "server/core/pose/ray_kernels.h"
#include "server/core/pose/robust_refinement.h"
#include "server/core/pose/scene_predictions.h"

namespace treeline::pose {

struct RayRefinementOptions {
  int iterations = 10;
  // Scale of the robust loss at the last iteration (units of the ray); it
  // starts three times as large and shrinks.
  double robust_scale = 4.0 / 525;
  // Rays with a prediction reprojected within this distance are inliers.
  double inlier_distance = 8.0 / 525;
};

// Minimises the robust sum of squared reprojection errors (thesis Eq. 3.12),
// each weighted by the observation's noise and the prediction's covariance
// seen from the camera; every ray picks its nearest prediction anew in each
// iteration. nullopt: the inliers do not determine a pose.
std::optional<RefinedPose> RefineRays(const RayPredictions& scene,
                                      const geometry::Rigid3& world_from_camera,
                                      const RayRefinementOptions& options);

// A few steps towards the same minimum, with the rays' best predictions alone
// and a robust loss that keeps its scale: for hypotheses.
std::optional<geometry::Rigid3> RefineOnBestPredictions(
    const PackedRays& rays, const geometry::Rigid3& world_from_camera,
    double robust_scale, int iterations);

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_RAY_REFINEMENT_H_
