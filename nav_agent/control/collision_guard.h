// The last thing between a command and the base: it does not let the robot run
// into what is seen or known, whoever gave the command.
#ifndef NAV_AGENT_CONTROL_COLLISION_GUARD_H_
#define NAV_AGENT_CONTROL_COLLISION_GUARD_H_

#include <span>
#include <vector>

#include "absl/status/status.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/control/footprint.h"
#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::control {

struct CollisionGuardOptions {
  // Room that is kept to points that were measured, and to the centres of cells
  // of the map (m).
  double point_margin_m = kPointMargin_m;
  double cell_margin_m = kCellMargin_m;
  // To points on what the map does not have: people and carts are wider above
  // and below the laser's plane (m).
  double new_margin_m = kBodyWidening_m;
  // What more is kept for each m/s of speed (s).
  double margin_per_speed_s = kMarginPerSpeed_s;
  // From a command until the base obeys it (s).
  double reaction_s = kReaction_s;
  // The share of the robot's deceleration that is counted on: slopes.
  double braking_share = kBrakingShare;
  // What moves may come towards the robot so fast (m/s); room that is kept to
  // it if it is no more than what is seen, and if it is somebody who is wider
  // (m).
  double approach_mps = kApproachSpeed_mps;
  double moving_margin_m = kMovingMargin_m;
  double body_margin_m = kBodyMargin_m;
  // From the middle of somebody who is not seen (m).
  double lost_margin_m = kLostMargin_m;
  // Where somebody may be, no edge of the robot moves outwards faster (m/s).
  double outward_mps = kOutwardSpeed_mps;

  absl::Status Validate() const;
};

struct GuardPoint {
  geometry::Vec2 in_base;
  // Kept free beside the footprint (m).
  double margin_m = 0;
  // It may come nearer by itself (m/s).
  double approach_mps = 0;
  // It is of somebody: the rest may be anywhere within its margin.
  bool is_of_body = false;
};

struct GuardVerdict {
  core::VelocityCommand command;
  // The command is another one than was wanted because of a point.
  bool is_limited = false;
  // What forbade the wanted command: where (m), and whether it moves.
  geometry::Vec2 point_in_base;
  bool point_moves = false;
};

// For each command: what the robot does if it obeys for the reaction time and
// then brakes as hard as it can; the command is allowed if no point comes
// nearer to the footprint than its margin on that way. What is nearer already
// must not come nearer still: away from it the robot may always drive. If the
// command is not allowed, the fastest one along the same arc that is.
//
// Somebody who moves is larger than the point that is seen, and may be anywhere
// within its margin and the way that it may have come since: an edge of the
// robot that is in there must not move outwards. So whoever touches the robot
// has run into it.
//
// Pure; limits of speed and acceleration are the caller's.
class CollisionGuard {
 public:
  CollisionGuard(const core::RobotModel& robot,
                 const CollisionGuardOptions& options);

  GuardVerdict Check(const core::VelocityCommand& wanted,
                     std::span<const GuardPoint> points) const;
  // A point so far from the base matters to no command (m).
  double Reach_m() const;
  const CollisionGuardOptions& options() const { return options_; }
  const Footprint& footprint() const { return footprint_; }

 private:
  // The first point that forbids a command; none: the end of `points`.
  const GuardPoint* FirstHit(const core::VelocityCommand& command,
                             std::span<const GuardPoint> points,
                             std::span<const double> now_m) const;

  // From a velocity to standing still, once the base obeys (s).
  double StopTime_s(double forward_mps, double yaw_rate_radps) const;
  // Of a sweep until then, a step of its edges apart.
  int LooksAt(double forward_mps, double yaw_rate_radps) const;

  core::RobotModel robot_;
  CollisionGuardOptions options_;
  Footprint footprint_;
  int max_looks_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_COLLISION_GUARD_H_
