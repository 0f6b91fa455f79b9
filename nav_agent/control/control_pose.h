// Where the robot is when something is seen or decided, and how it moves then.
#ifndef NAV_AGENT_CONTROL_CONTROL_POSE_H_
#define NAV_AGENT_CONTROL_CONTROL_POSE_H_

#include <vector>

#include "common/base/clock.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::control {

struct ControlPose {
  base::MonotonicTime stamp;
  core::LevelPose pose;
  // Pitch and roll (SlopeOdometry::LevelFromBase).
  geometry::Rotation3 level_from_base;
  double forward_mps = 0;
  double yaw_rate_radps = 0;
  // The robot is lost: `pose` is dead reckoning's, and the map says nothing of
  // what stands there; only what was seen counts. Obstacles are to be cleared
  // when this changes.
  bool map_is_unknown = false;
  // Where a robot that is lost may be on the map: what the map has there, low
  // things that no laser sees above all, must not be run into either.
  std::vector<core::LevelPose> supposed = {};
};

// The robot in space, on the ground that it stands on.
inline geometry::Rigid3 MapFromBase3(const ControlPose& pose) {
  const geometry::Rigid2& planar = pose.pose.map_from_base;
  return {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0, planar.yaw_rad}) *
                  pose.level_from_base,
      .translation = {planar.translation.x, planar.translation.y,
                      pose.pose.place.height_m}};
}

// Where a robot that obeys a command for time_s comes to, from where it was.
inline geometry::Rigid2 MotionIn(double time_s,
                                 const core::VelocityCommand& command) {
  const double turn_rad = command.yaw_rate_radps * time_s;
  const double way_m = command.forward_mps * time_s;
  return {.translation = {way_m * std::cos(0.5 * turn_rad),
                          way_m * std::sin(0.5 * turn_rad)},
          .yaw_rad = turn_rad};
}

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_CONTROL_POSE_H_
