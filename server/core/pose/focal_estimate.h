// Whether rays, or measured points, were made with the right focal length, and
// whether rays were made with the right lens.
#ifndef SERVER_CORE_POSE_FOCAL_ESTIMATE_H_
#define SERVER_CORE_POSE_FOCAL_ESTIMATE_H_

#include <array>
#include <optional>

#include "common/geometry/rigid3.h"
#include "server/core/pose/scene_predictions.h"

namespace treeline::pose {

// The true focal length is `scale` times the stated one.
struct FocalEstimate {
  double scale = 1;
  // Standard deviation of log(scale).
  double sigma = 0;
  // What not to know it adds to the covariance of a pose with it; zero of
  // measured points, which hold the pose.
  geometry::PoseCovariance added{};
};

// Likewise of a camera whose principal point and distortion are unknown, too:
// the ray of a point in the camera, with (x, y) = (X/Z, Y/Z), is
// focal.scale (1 + radial (x^2 + y^2)) (x, y) + offset.
struct LensEstimate {
  FocalEstimate focal;
  double offset_x = 0;
  double offset_y = 0;
  double radial = 0;
  // Of the offset and the distortion, symmetric, by rows.
  std::array<double, 9> covariance{};
  // What not to know the camera adds to the covariance of a pose with it.
  geometry::PoseCovariance added{};
};

// How far from 0 a lens is expected, standard deviations.
struct LensPrior {
  double offset = 0;  // units of the ray
  double radial = 0;
};

// Minimises the robust sum of squared reprojection errors of the rays' best
// predictions over the pose and the focal length at once, from
// `world_from_camera` and a scale of 1. `robust_scale` is that of the last
// iteration (units of the ray). nullopt: the rays do not determine it, as where
// all that is seen is one wall in front of the camera.
std::optional<FocalEstimate> EstimateFocal(
    const RayPredictions& scene, const geometry::Rigid3& world_from_camera,
    double robust_scale);

// The same over the lens, too.
std::optional<LensEstimate> EstimateLens(
    const RayPredictions& scene, const geometry::Rigid3& world_from_camera,
    double robust_scale, const LensPrior& prior);

// Of points that the same camera measured, so that a wrong focal length
// stretches them across its axis: minimises the robust sum of squared distances
// between them and their nearest predictions over the pose, the focal length
// and the scale of depth at once. That scale is 1 but for kDepthScaleSigma.
std::optional<FocalEstimate> EstimateFocal(
    const PointPredictions& scene, const geometry::Rigid3& world_from_camera);

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_FOCAL_ESTIMATE_H_
