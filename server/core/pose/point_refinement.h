// The last word on a pose from measured points: robust, weighted, with a
// covariance.
#ifndef SERVER_CORE_POSE_POINT_REFINEMENT_H_
#define SERVER_CORE_POSE_POINT_REFINEMENT_H_

#include <cstddef>
#include <limits>
#include <optional>

#include "common/geometry/rigid3.h"
#include "server/core/pose/robust_refinement.h"
#include "server/core/pose/scene_predictions.h"

namespace treeline::pose {

struct PointRefinementOptions {
  int iterations = 8;
  // Scale of the robust loss at the last iteration (m): a residual of this
  // size has a quarter of the weight of none (Geman-McClure). It starts three
  // times as large and shrinks.
  double robust_scale_m = 0.04;
  // Floor of a prediction's standard deviation (m), for what the leaf's own
  // covariance cannot know: calibration, motion blur, few samples.
  double model_sigma_m = 0.01;
  // Points with a prediction within this distance are inliers (m).
  double inlier_distance_m = 0.05;
  // Of a point's predictions take the likeliest (thesis Eq. 5.6), not the
  // nearest.
  bool likeliest_prediction = false;
  // Levenberg-Marquardt: a step that raises the sum is damped and tried again.
  bool levenberg_marquardt = false;
  // A point on a line and its prediction are this far apart along it at most
  // (m).
  double max_slide_m = 0.2;
  // Looks at the first so many points.
  size_t max_points = std::numeric_limits<size_t>::max();
};

// Gauss-Newton on
//   sum_i min over k of rho( r^T (S_ik + s_i^2 R v v^T R^T + s^2 I)^-1 r ),
//   r = world_from_camera * x_i - m_ik,
// where S_ik is the covariance of prediction k of point i, s_i the depth noise
// along the viewing ray v. For a point on a line, x_i is the line's point next
// to m_ik (thesis Eq. 5.8), and the distance from which rho weighs is that to
// the line. Each point picks its prediction, and each line its point, anew in
// every iteration. nullopt: the inliers do not determine a pose.
std::optional<RefinedPose> RefinePoints(
    const PointPredictions& scene, const geometry::Rigid3& world_from_camera,
    const PointRefinementOptions& options);

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_POINT_REFINEMENT_H_
