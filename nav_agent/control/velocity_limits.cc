#include "nav_agent/control/velocity_limits.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace treeline::control {
namespace {

double FiniteOr0(double value) { return std::isfinite(value) ? value : 0; }

}  // namespace

core::VelocityCommand LimitedVelocity(const core::VelocityCommand& present,
                                      const core::VelocityCommand& wanted,
                                      double interval_s,
                                      const core::RobotModel& robot) {
  const double from = FiniteOr0(present.forward_mps);
  const double to = std::clamp(FiniteOr0(wanted.forward_mps),
                               -robot.max_backward_mps, robot.max_forward_mps);
  const double up = robot.max_acceleration_mps2 * interval_s;
  const double down = robot.max_deceleration_mps2 * interval_s;
  core::VelocityCommand limited;
  if (from > 0) {
    limited.forward_mps =
        to >= from ? std::min(to, from + up) : std::max({to, from - down, -up});
    // Through standing still only in the next step.
    if (to < 0) limited.forward_mps = std::max(from - down, 0.0);
  } else if (from < 0) {
    limited.forward_mps =
        to <= from ? std::max(to, from - up) : std::min(to, from + down);
    if (to > 0) limited.forward_mps = std::min(from + down, 0.0);
  } else {
    limited.forward_mps = std::clamp(to, -up, up);
  }
  const double turn = robot.max_yaw_acceleration_radps2 * interval_s;
  const double yaw_from = FiniteOr0(present.yaw_rate_radps);
  limited.yaw_rate_radps = std::clamp(
      std::clamp(FiniteOr0(wanted.yaw_rate_radps), -robot.max_yaw_rate_radps,
                 robot.max_yaw_rate_radps),
      yaw_from - turn, yaw_from + turn);
  return limited;
}

core::VelocityCommand LimitedTogether(const core::VelocityCommand& present,
                                      const core::VelocityCommand& wanted,
                                      double interval_s,
                                      const core::RobotModel& robot) {
  const core::VelocityCommand each =
      LimitedVelocity(present, wanted, interval_s, robot);
  const auto share = [](double from, double to, double limited) {
    const double change = FiniteOr0(to) - FiniteOr0(from);
    return change == 0 ? 1.0 : (limited - FiniteOr0(from)) / change;
  };
  const double both = std::clamp(
      std::min(share(present.forward_mps, wanted.forward_mps, each.forward_mps),
               share(present.yaw_rate_radps, wanted.yaw_rate_radps,
                     each.yaw_rate_radps)),
      0.0, 1.0);
  const auto between = [both](double from, double to) {
    return std::lerp(FiniteOr0(from), FiniteOr0(to), both);
  };
  return {
      .forward_mps = between(present.forward_mps, wanted.forward_mps),
      .yaw_rate_radps = between(present.yaw_rate_radps, wanted.yaw_rate_radps)};
}

LastCommands::Start LastCommands::StartAt(base::MonotonicTime now,
                                          const core::VelocityCommand& measured,
                                          const core::RobotModel& robot) const {
  Start start = {
      .velocity = {.forward_mps = FiniteOr0(measured.forward_mps),
                   .yaw_rate_radps = FiniteOr0(measured.yaw_rate_radps)},
      .interval_s = kCycle_s};
  const std::optional<Entry>& before =
      last_.has_value() && last_->stamp == now ? before_ : last_;
  if (!before.has_value()) return start;
  const double since_s =
      std::chrono::duration<double>(now - before->stamp).count();
  if (since_s < 0 || since_s > kLag_s) return start;
  start.interval_s = std::clamp(since_s, kMinInterval_s, kLag_s);
  const double lag_s = kLag_s + start.interval_s;
  if (std::abs(before->command.forward_mps - start.velocity.forward_mps) <=
      robot.max_deceleration_mps2 * lag_s) {
    start.velocity.forward_mps = before->command.forward_mps;
  }
  if (std::abs(before->command.yaw_rate_radps -
               start.velocity.yaw_rate_radps) <=
      robot.max_yaw_acceleration_radps2 * lag_s) {
    start.velocity.yaw_rate_radps = before->command.yaw_rate_radps;
  }
  return start;
}

void LastCommands::Told(base::MonotonicTime now,
                        const core::VelocityCommand& command) {
  if (!last_.has_value() || last_->stamp != now) before_ = last_;
  last_ = Entry{.stamp = now, .command = command};
}

}  // namespace treeline::control
