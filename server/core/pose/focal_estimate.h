// Whether rays, or measured points, were made with the right focal length.
#ifndef SERVER_CORE_POSE_FOCAL_ESTIMATE_H_
#define SERVER_CORE_POSE_FOCAL_ESTIMATE_H_

#include <optional>

#include "common/geometry/rigid3.h"
#include "server/core/pose/scene_predictions.h"

namespace treeline::pose {

// The true focal length is `scale` times the stated one.
struct FocalEstimate {
  double scale = 1;
  // Standard deviation of log(scale).
  double sigma = 0;
};

// Minimises the robust sum of squared reprojection errors of the rays' best
// predictions over the pose and the focal length at once, from
// `world_from_camera` and a scale of 1. `robust_scale` is that of the last
// iteration (units of the ray). nullopt: the rays do not determine it, as where
// all that is seen is one wall in front of the camera.
std::optional<FocalEstimate> EstimateFocal(
    const RayPredictions& scene, const geometry::Rigid3& world_from_camera,
    double robust_scale);

// Of points that the same camera measured, so that a wrong focal length
// stretches them across its axis: minimises the robust sum of squared distances
// between them and their nearest predictions over the pose, the focal length
// and the scale of depth at once. That scale is 1 but for kDepthScaleSigma.
std::optional<FocalEstimate> EstimateFocal(
    const PointPredictions& scene, const geometry::Rigid3& world_from_camera);

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_FOCAL_ESTIMATE_H_
