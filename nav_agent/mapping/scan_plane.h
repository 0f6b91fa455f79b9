// The plane that the beams of a levelled scan lie in, and whether two scans
// see the same things.
#ifndef NAV_AGENT_MAPPING_SCAN_PLANE_H_
#define NAV_AGENT_MAPPING_SCAN_PLANE_H_

#include <cmath>

#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"

namespace treeline::mapping {

// The ground that the robot stands on; the laser's plane is parallel to it.
struct ScanPlane {
  geometry::Vec2 at;  // in the map
  double height_m = 0;
  // How steeply it climbs along the map's x and y (m per m).
  geometry::Vec2 slope;
};

// The slope of the ground along the level frame's x and y. For tilts below
// 1 rad.
inline geometry::Vec2 SlopeUnder(const geometry::Rotation3& level_from_base) {
  if (std::hypot(level_from_base.x, level_from_base.y) < 5e-5) return {};
  const geometry::Vec3 up = level_from_base * geometry::Vec3{0, 0, 1};
  return {-up.x / up.z, -up.y / up.z};
}

inline geometry::Vec2 TurnedBy(double yaw_rad, geometry::Vec2 a) {
  return geometry::Rigid2{.translation = {}, .yaw_rad = yaw_rad} * a;
}

// How much higher b is than a, and how much of that the slopes under both do
// not explain: along one ramp, and on one floor, nothing.
inline double ClimbBySlope_m(const ScanPlane& a, const ScanPlane& b) {
  return 0.5 * geometry::Dot(a.slope + b.slope, b.at - a.at);
}
inline double Gap_m(const ScanPlane& a, const ScanPlane& b) {
  return std::abs(b.height_m - a.height_m - ClimbBySlope_m(a, b));
}
inline double TiltBetween(const ScanPlane& a, const ScanPlane& b) {
  return geometry::Norm(b.slope - a.slope);
}

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_SCAN_PLANE_H_
