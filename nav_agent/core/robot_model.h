// The measures of a robot: what of it may touch what, how it may move, and
// where its sensors are.
#ifndef NAV_AGENT_CORE_ROBOT_MODEL_H_
#define NAV_AGENT_CORE_ROBOT_MODEL_H_

#include <cstdint>
#include <numbers>

#include "absl/status/status.h"
#include "common/geometry/rigid3.h"

namespace treeline::core {

// Which of a robot's planar lasers: the one ahead, that it also maps and
// localizes with; or one that looks back, for what comes from there.
enum class LaserMount : uint8_t { kFront = 0, kRear = 1 };

// A robot with two driven wheels, and casters before and behind them. The base
// frame lies on the ground below the middle of the axle: x forward, y left,
// z up at right angles to the ground that the wheels stand on (REP 105's
// base_footprint on level ground). Defaults: a Segway RMP100 with casters, a
// UTM-30LX low in front and an Xtion on a post (thesis 6.2), and where there is
// a laser that looks back, it is as low behind.
struct RobotModel {
  // The footprint is a rectangle: from the axle forward, backward, and to each
  // side (m).
  double front_m = 0.30;
  double rear_m = 0.30;
  double half_width_m = 0.31;
  // Nothing of the robot is higher than this.
  double height_m = 1.25;
  // Room below its body: lower things pass under it, between the wheels.
  double ground_clearance_m = 0.06;

  double wheel_track_m = 0.54;
  double wheel_radius_m = 0.20;
  // Casters touch the ground this far before and behind the axle.
  double caster_m = 0.25;
  // The highest step that wheels and casters climb, and the steepest ground on
  // which the robot stands safely.
  double max_step_m = 0.02;
  double max_slope_rad = 0.28;

  double max_forward_mps = 0.8;
  double max_backward_mps = 0.3;
  double max_yaw_rate_radps = 1.5;
  double max_acceleration_mps2 = 0.8;
  double max_deceleration_mps2 = 1.5;
  double max_yaw_acceleration_radps2 = 3.0;

  // The laser's frame has x forward, y left; camera frames x right, y down,
  // z forward. The camera is the pose sensor of its calibration.
  geometry::Rigid3 base_from_laser = {.rotation = {},
                                      .translation = {0.22, 0, 0.35}};
  geometry::Rigid3 base_from_rear_laser = {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0, std::numbers::pi}),
      .translation = {-0.22, 0, 0.35}};
  geometry::Rigid3 base_from_camera = UprightCamera({0.12, 0, 1.10}, 0.21);

  const geometry::Rigid3& BaseFrom(LaserMount laser) const {
    return laser == LaserMount::kRear ? base_from_rear_laser : base_from_laser;
  }

  // The pose of a camera at `position_in_base` that looks ahead, and down_rad
  // below the horizon.
  static geometry::Rigid3 UprightCamera(geometry::Vec3 position_in_base,
                                        double down_rad);

  // The radius of the circle about the base's origin that holds the footprint.
  double Circumradius_m() const;

  // INVALID_ARGUMENT for what is not finite or positive, or contradicts
  // itself.
  absl::Status Validate() const;
};

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_ROBOT_MODEL_H_
