// A robot's file (docs/reference/robots.md) of a URDF.
#ifndef NAV_AGENT_URDF_URDF_ROBOT_H_
#define NAV_AGENT_URDF_URDF_ROBOT_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/urdf/urdf_file.h"

namespace treeline::urdf {

// Names of links; empty: the one whose name says so, or none. What else is in a
// robot's file (speeds, how lasers scan) comes from the robot `like`.
struct UrdfRobotOptions {
  std::string base_link{};
  std::string laser_link{};
  std::string rear_laser_link{};
  std::string camera_link{};
  std::string like = "rmp100";
};

struct UrdfRobot {
  // A robot's file, with comments.
  std::string yaml;
  // What was guessed or is missing, a sentence each.
  std::vector<std::string> notes;
};

// What of the robot's collision shapes is above the ground, seen from above:
// the convex hull of their projections, counter-clockwise in the frame of
// `base`, at most kMaxCorners corners; curves and hulls of more corners are
// enclosed. Empty: there are no shapes.
inline constexpr size_t kMaxCorners = 32;
std::vector<geometry::Vec2> FootprintOf(const Urdf& urdf, size_t base);

// The robot's file: footprint, height, wheels (of continuous joints whose links
// are cylinders or spheres on both sides), and the places of lasers and camera,
// above the ground: that of base_footprint, or else the lowest shape.
// INVALID_ARGUMENT: a link is not there or several may be meant, a laser is
// mounted on its head or tilted, there is no footprint, or the robot's measures
// contradict each other.
absl::StatusOr<UrdfRobot> RobotOfUrdf(const Urdf& urdf,
                                      const UrdfRobotOptions& options);

}  // namespace treeline::urdf

#endif  // NAV_AGENT_URDF_URDF_ROBOT_H_
