// Where a camera is, from points that it sees.
#ifndef NAV_AGENT_RGBD_SLAM_POSE_SOLVER_H_
#define NAV_AGENT_RGBD_SLAM_POSE_SOLVER_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/rigid3.h"
#include "nav_agent/rgbd_slam/binary_features.h"

namespace treeline::rgbd_slam {

// A point of the map and how it was measured.
struct PointSighting {
  geometry::Vec3 point_in_map;
  camera::Pixel pixel;
  // Along the optical axis (m); 0: not measured.
  double depth_m = 0;
  // Standard deviation of the pixel.
  double sigma_px = 1;
};

// Standard deviation of a feature's measured depth: that of the sensor, which
// grows with the square (Khoshelham, Elberink 2012), and of the surface's slant
// below a corner that is a pixel or two away from where it seems.
double FeatureDepthSigma_m(double depth_m);

// Bounds on squared errors over variances, 95 % of two and of three degrees of
// freedom: beyond, a sighting is not of that point.
constexpr double kMaxSquaredError2 = 5.991;
constexpr double kMaxSquaredError3 = 7.815;

// Squared errors over variances: of pixel, and of depth where it was measured.
// Infinite for points behind the camera.
double SquaredError(const PointSighting& sighting, const Pinhole& pinhole,
                    const geometry::Rigid3& camera_from_map);
bool IsExplained(const PointSighting& sighting, const Pinhole& pinhole,
                 const geometry::Rigid3& camera_from_map);

struct SolvedPose {
  geometry::Rigid3 camera_from_map;
  // For each sighting, whether it agrees with the pose.
  std::vector<bool> is_inlier;
  int inliers = 0;
};

// The pose that minimises Huber's norm of the errors of pixel and depth, from
// `initial` on: Gauss-Newton with a few rounds of looking again at who is
// wrong. With fewer than 6 sightings, none is taken for an inlier.
SolvedPose SolvePose(std::span<const PointSighting> sightings,
                     const Pinhole& pinhole,
                     const geometry::Rigid3& initial_camera_from_map);

// The pose from sightings of which most may be wrong: rigid transforms (Horn)
// of three sightings with depth at a time (RANSAC), then SolvePose. nullopt if
// fewer than min_inliers agree. Draws are functions of (seed, stream).
std::optional<SolvedPose> FindPose(std::span<const PointSighting> sightings,
                                   const Pinhole& pinhole, int min_inliers,
                                   uint64_t seed, uint64_t stream);

}  // namespace treeline::rgbd_slam

#endif  // NAV_AGENT_RGBD_SLAM_POSE_SOLVER_H_
