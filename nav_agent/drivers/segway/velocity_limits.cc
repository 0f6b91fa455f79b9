#include "nav_agent/drivers/segway/velocity_limits.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"

namespace treeline::segway {
namespace {

double Step(double current, double target, double max_gain, double max_loss) {
  if (current * target < 0) target = 0;
  const double max_change =
      std::abs(target) > std::abs(current) ? max_gain : max_loss;
  return current + std::clamp(target - current, -max_change, max_change);
}

}  // namespace

absl::Status VelocityLimits::Validate() const {
  for (const double limit :
       {max_forward_mps, max_backward_mps, max_yaw_rate_radps,
        max_acceleration_mps2, max_deceleration_mps2,
        max_yaw_acceleration_radps2}) {
    if (!std::isfinite(limit) || limit <= 0) {
      return absl::InvalidArgumentError(
          absl::StrCat("a limit of the base's velocity is ", limit,
                       "; it has to be "
                       "positive"));
    }
  }
  return absl::OkStatus();
}

core::VelocityCommand Limited(const core::VelocityCommand& command,
                              const VelocityLimits& limits) {
  const double forward = command.forward_mps >= 0
                             ? command.forward_mps / limits.max_forward_mps
                             : -command.forward_mps / limits.max_backward_mps;
  const double turn =
      std::abs(command.yaw_rate_radps) / limits.max_yaw_rate_radps;
  const double excess = std::max({1.0, forward, turn});
  return {.forward_mps = command.forward_mps / excess,
          .yaw_rate_radps = command.yaw_rate_radps / excess};
}

core::VelocityCommand Approach(const core::VelocityCommand& current,
                               const core::VelocityCommand& target,
                               const VelocityLimits& limits,
                               double interval_s) {
  const double max_turn_change =
      limits.max_yaw_acceleration_radps2 * interval_s;
  return {.forward_mps = Step(current.forward_mps, target.forward_mps,
                              limits.max_acceleration_mps2 * interval_s,
                              limits.max_deceleration_mps2 * interval_s),
          .yaw_rate_radps = Step(current.yaw_rate_radps, target.yaw_rate_radps,
                                 max_turn_change, max_turn_change)};
}

}  // namespace treeline::segway
