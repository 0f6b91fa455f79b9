// How fast and how suddenly a base may be asked to move.
#ifndef NAV_AGENT_DRIVERS_SEGWAY_VELOCITY_LIMITS_H_
#define NAV_AGENT_DRIVERS_SEGWAY_VELOCITY_LIMITS_H_

#include "absl/status/status.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::segway {

// Defaults are those of RobotModel.
struct VelocityLimits {
  double max_forward_mps = 0.8;
  double max_backward_mps = 0.3;
  double max_yaw_rate_radps = 1.5;
  double max_acceleration_mps2 = 0.8;
  double max_deceleration_mps2 = 1.5;
  double max_yaw_acceleration_radps2 = 3.0;

  // INVALID_ARGUMENT for what is not finite and positive.
  absl::Status Validate() const;
};

// The command, slowed down until it is within the limits, along the same arc:
// both speeds shrink by the same factor. `command` is finite.
core::VelocityCommand Limited(const core::VelocityCommand& command,
                              const VelocityLimits& limits);

// What to ask for `interval_s` after `current` on the way to `target`: each
// speed changes by no more than the limits allow, and passes through zero
// before it changes its sign.
core::VelocityCommand Approach(const core::VelocityCommand& current,
                               const core::VelocityCommand& target,
                               const VelocityLimits& limits, double interval_s);

}  // namespace treeline::segway

#endif  // NAV_AGENT_DRIVERS_SEGWAY_VELOCITY_LIMITS_H_
