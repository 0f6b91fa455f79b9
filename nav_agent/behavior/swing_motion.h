// Turns of a lost robot: towards a direction, and round and round where
// something may hold it.
#ifndef NAV_AGENT_BEHAVIOR_SWING_MOTION_H_
#define NAV_AGENT_BEHAVIOR_SWING_MOTION_H_

#include <array>
#include <optional>

#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/relocalization_behavior.h"
#include "nav_agent/localization/robot_tracker.h"

namespace treeline::behavior {

// Who turns slower than half of the slowest turn that is wanted is held, and
// creeps along something.
inline constexpr double kHeldTurn_radps = kMinTurnSpeed_radps / 2;

// Slower near the end; `yaw_in_odom_rad` is in the frame of the odometry.
core::VelocityCommand TurnTowards(double yaw_in_odom_rad,
                                  const localization::TrackedMotion& motion,
                                  double max_radps);

// Turns on; where something holds the robot, it swings there and back as far as
// that and the collision stop let it, and goes ahead if that is nowhere. Keeps
// its side from one recovery to the next. Not thread-safe.
class SwingMotion {
 public:
  // The robot may be elsewhere: what held it does not count any more.
  void ForgetHeld() { held_at_ = {}; }

  core::VelocityCommand Step(const localization::TrackedMotion& motion,
                             const RelocalizationInput& input,
                             double turn_radps, double move_mps);

 private:
  // 1: to the left, -1: to the right.
  double side_ = 1;
  // Since when it has not moved to this side, and how often in a row that was
  // so.
  std::optional<base::MonotonicTime> blocked_since_;
  int sides_blocked_ = 0;
  // Where something held it last that it turned to: right, left.
  std::array<std::optional<geometry::Rigid2>, 2> held_at_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_SWING_MOTION_H_
