#include "nav_agent/bridge/robot_ports/base_port.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::robot_ports {
namespace {

// Zeros go on for so long after the robot was told to stand.
constexpr double kStandFor_s = 1;
constexpr core::VelocityCommand kStand;

bool IsFinite(const core::VelocityCommand& command) {
  return std::isfinite(command.forward_mps) &&
         std::isfinite(command.yaw_rate_radps);
}

}  // namespace

BasePort::BasePort(std::string topic, const base::Clock& real_clock, Wire wire)
    : topic_(std::move(topic)),
      real_clock_(real_clock),
      wire_(std::move(wire)) {}

BasePort::~BasePort() {
  const absl::MutexLock lock(&mutex_);
  if (moved_.has_value()) Send(kStand);
}

void BasePort::Send(const core::VelocityCommand& command) {
  last_error_ = wire_.send(command);
  last_ = command;
  if (last_error_.ok()) ++sent_;
}

absl::Status BasePort::SetVelocity(const core::VelocityCommand& command) {
  const bool is_finite = IsFinite(command);
  const absl::Status obstacle = wire_.obstacle();
  const core::VelocityCommand obeyed =
      is_finite && obstacle.ok() ? command : kStand;
  const absl::MutexLock lock(&mutex_);
  const base::MonotonicTime now = real_clock_.Now();
  given_ = now;
  if (obeyed != kStand) moved_ = now;
  if (moved_.has_value() && base::SecondsBetween(*moved_, now) > kStandFor_s) {
    moved_.reset();
  }
  if (moved_.has_value()) {
    Send(obeyed);
  } else {
    // What is not tried does not fail.
    last_error_ = absl::OkStatus();
  }
  if (!is_finite) {
    return absl::InvalidArgumentError(
        absl::StrCat("a velocity of ", command.forward_mps, " m/s and ",
                     command.yaw_rate_radps, " rad/s: the robot stands"));
  }
  if (!obstacle.ok()) return obstacle;
  if (wire_.listeners() == 0) {
    return absl::UnavailableError(absl::StrCat("nobody listens on ", topic_));
  }
  return last_error_;
}

void BasePort::Stop() { SetVelocity(kStand).IgnoreError(); }

void BasePort::Watch() {
  const absl::MutexLock lock(&mutex_);
  if (last_ == kStand ||
      base::SecondsBetween(given_, real_clock_.Now()) <= kCommandLifetime_s) {
    return;
  }
  Send(kStand);
}

core::DeviceHealth BasePort::Health() const {
  core::DeviceHealth health;
  const bool is_heard = wire_.listeners() > 0;
  const std::string why = is_heard ? "" : wire_.why_nobody();
  const absl::Status obstacle = wire_.obstacle();
  const absl::MutexLock lock(&mutex_);
  health.received = sent_;
  health.state =
      is_heard ? core::DeviceState::kRunning : core::DeviceState::kLost;
  if (!is_heard) {
    health.cause = absl::UnavailableError(
        why.empty() ? absl::StrCat("nobody listens on ", topic_) : why);
  } else if (!obstacle.ok() || !last_error_.ok()) {
    health.state = core::DeviceState::kLost;
    health.cause = obstacle.ok() ? last_error_ : obstacle;
  }
  return health;
}

}  // namespace treeline::robot_ports
