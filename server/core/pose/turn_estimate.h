// How a camera turned while the rows of its picture were read.
#ifndef SERVER_CORE_POSE_TURN_ESTIMATE_H_
#define SERVER_CORE_POSE_TURN_ESTIMATE_H_

#include <optional>
#include <span>

#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"

namespace treeline::pose {

// A point of the scene, and where it is seen.
struct TimedRay {
  geometry::Vec3 point_in_world;
  camera::Pixel ray;  // (x/z, y/z)
  // When its row was exposed, after the picture's time stamp (s).
  double delay_s = 0;
};

struct TurnOptions {
  // Of the robust loss, and of an observation (units of the ray).
  double robust_scale = 0;
  // Further away is no match (units of the ray).
  double inlier_distance = 0;
  // What is expected beforehand of each axis (rad/s).
  double prior_sigma_rad_s = 0;
  int min_inliers = 0;
};

struct TurnEstimate {
  // About the camera's own axes (rad/s).
  geometry::Vec3 turn_rate_rad_s;
  // turn_rate / its standard deviation, over all axes (Mahalanobis).
  double sigmas = 0;
  // What not knowing the turn rate better adds to the covariance of a pose at
  // the time stamp.
  geometry::PoseCovariance added_covariance{};
  int inliers = 0;
};

// Minimises over the pose at the time stamp and the turn rate w
//   sum robust(|project(exp(-w delay) camera_from_world X) - ray|^2)
// and the prior, from `world_from_camera` and no turn. nullopt: too few rays
// agree, or they do not determine it.
std::optional<TurnEstimate> EstimateTurn(
    std::span<const TimedRay> rays, const geometry::Rigid3& world_from_camera,
    const TurnOptions& options);

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_TURN_ESTIMATE_H_
