// What a base may be asked for next, given how it moves.
#ifndef NAV_AGENT_CONTROL_VELOCITY_LIMITS_H_
#define NAV_AGENT_CONTROL_VELOCITY_LIMITS_H_

#include <optional>

#include "common/base/clock.h"
#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::control {

// The velocity nearest to `wanted` that can be reached from `present` within
// interval_s: speeds within the robot's, |forward| grows by at most
// max_acceleration and falls by at most max_deceleration, yaw rates change by
// at most max_yaw_acceleration. NaN and infinity count as 0.
core::VelocityCommand LimitedVelocity(const core::VelocityCommand& present,
                                      const core::VelocityCommand& wanted,
                                      double interval_s,
                                      const core::RobotModel& robot);

// The same, on the straight line from `present` to `wanted`: what brakes goes
// on along its arc, and no part of the robot moves in a direction that it has
// in neither. An edge that the way ahead takes along with a turn would move
// back if the way ended first.
core::VelocityCommand LimitedTogether(const core::VelocityCommand& present,
                                      const core::VelocityCommand& wanted,
                                      double interval_s,
                                      const core::RobotModel& robot);

// From how the base moves and what it was told last: what its next command
// starts from. What a base says of its speed is late by one or two cycles: with
// it alone, a base would accelerate at half of what it may.
class LastCommands {
 public:
  // What limits start from at `now`, and the time since then (s, 0.005 to
  // 0.1). Told twice in the same instant, both start from the same.
  struct Start {
    core::VelocityCommand velocity;
    double interval_s = kCycle_s;
  };
  Start StartAt(base::MonotonicTime now, const core::VelocityCommand& measured,
                const core::RobotModel& robot) const;
  void Told(base::MonotonicTime now, const core::VelocityCommand& command);

 private:
  struct Entry {
    base::MonotonicTime stamp;
    core::VelocityCommand command;
  };
  std::optional<Entry> last_;
  std::optional<Entry> before_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_VELOCITY_LIMITS_H_
