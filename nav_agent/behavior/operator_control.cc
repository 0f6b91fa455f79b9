#include "nav_agent/behavior/operator_control.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"

namespace treeline::behavior {

bool LatchedStop::Hold(const std::string& why, base::MonotonicTime now) {
  if (stop_.has_value()) return false;
  stop_ = {.why = why, .since = now};
  events_->Add("stop", absl::StrCat("stopped until it is released: ", why));
  return true;
}

bool LatchedStop::Release(base::MonotonicTime now) {
  if (!stop_.has_value()) return false;
  events_->Add(
      "release",
      absl::StrFormat("released after %.1f s (%s)",
                      base::SecondsBetween(stop_->since, now), stop_->why));
  stop_.reset();
  return true;
}

absl::Status LatchedStop::Refuse(const std::string& what) const {
  if (!stop_.has_value()) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(what, " is refused: the robot is stopped (", stop_->why,
                   "); release it first"));
}

absl::Status ManualDrive::Drive(const core::VelocityCommand& wanted,
                                base::MonotonicTime now) {
  if (!std::isfinite(wanted.forward_mps) ||
      !std::isfinite(wanted.yaw_rate_radps)) {
    return absl::InvalidArgumentError("a velocity is not finite");
  }
  if (!driven_.has_value()) events_->Add("manual", "somebody drives by hand");
  wanted_ = wanted;
  driven_ = now;
  return absl::OkStatus();
}

std::optional<core::VelocityCommand> ManualDrive::Wanted(
    base::MonotonicTime now) {
  if (!driven_.has_value()) return std::nullopt;
  if (base::SecondsBetween(*driven_, now) > lease_s_) {
    End();
    return std::nullopt;
  }
  return wanted_;
}

void ManualDrive::End() {
  if (!driven_.has_value()) return;
  driven_.reset();
  events_->Add("manual", "nobody drives by hand any more");
}

}  // namespace treeline::behavior
