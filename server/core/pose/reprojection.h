// Where a camera sees a point of the world.
#ifndef SERVER_CORE_POSE_REPROJECTION_H_
#define SERVER_CORE_POSE_REPROJECTION_H_

#include <limits>

#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"

namespace treeline::pose {

// Nothing nearer than this (units of the world) is in front of the camera.
inline constexpr double kMinPointDepth = 1e-6;

// A rigid transform as its matrix: faster than quaternions for many points.
struct CameraFromWorld {
  explicit CameraFromWorld(const geometry::Rigid3& pose)
      : r(pose.rotation.Matrix()), t(pose.translation) {}
  geometry::Vec3 operator*(geometry::Vec3 point) const { return r * point + t; }

  geometry::Mat3 r;
  geometry::Vec3 t;
};

// Of the point's image (x/z, y/z) from `ray`; infinite behind the camera.
inline double SquaredReprojectionError(const CameraFromWorld& camera_from_world,
                                       geometry::Vec3 point_in_world,
                                       camera::Pixel ray) {
  const geometry::Vec3 p = camera_from_world * point_in_world;
  if (p.z < kMinPointDepth) return std::numeric_limits<double>::infinity();
  const double du = p.x / p.z - ray.x;
  const double dv = p.y / p.z - ray.y;
  return du * du + dv * dv;
}

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_REPROJECTION_H_
