#include "nav_agent/behavior/safe_stop.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "nav_agent/behavior/angle_text.h"
#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {
void SafeStop::Update(const std::vector<StopReason>& found,
                      base::MonotonicTime now) {
  if (!found.empty()) {
    last_found_ = now;
    if (!reason_.has_value()) begun_ = now;
    const bool is_new =
        !reason_.has_value() || reason_->cause != found.front().cause;
    reason_ = found.front();
    if (is_new) {
      events_->Add(
          "stop",
          absl::StrCat("stands (", core::NavigationCauseName(reason_->cause),
                       "): ", reason_->text));
    }
    return;
  }
  if (!reason_.has_value() ||
      base::SecondsBetween(last_found_, now) < limits_.settle_s) {
    return;
  }
  events_->Add("resume",
               absl::StrFormat("all is well again after %.1f s (%s)",
                               base::SecondsBetween(begun_, now),
                               core::NavigationCauseName(reason_->cause)));
  reason_.reset();
}

absl::Status SafeStop::Refuse(const std::string& what) const {
  if (!reason_.has_value()) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(what, " is refused: ", reason_->text));
}

void TiltMonitor::Add(const core::BaseReading& reading) {
  // The angle of the base's z axis to the vertical.
  tilt_rad_ = std::acos(std::clamp(
      std::cos(reading.pitch_rad) * std::cos(reading.roll_rad), -1.0, 1.0));
  stamp_ = reading.stamp;
  if (tilt_rad_ <= max_rad_) {
    since_.reset();
  } else if (!since_.has_value()) {
    since_ = stamp_;
  }
}

std::optional<StopReason> TiltMonitor::Problem() const {
  if (!since_.has_value() || base::SecondsBetween(*since_, stamp_) < for_s_) {
    return std::nullopt;
  }
  return StopReason{
      .cause = core::NavigationCause::kTilted,
      .text = absl::StrFormat("it leans by %.0f degrees; %.0f are safe",
                              InDegrees(tilt_rad_), InDegrees(max_rad_))};
}

void DeadlineMonitor::Step(base::MonotonicTime now) {
  gap_s_ = last_.has_value() ? base::SecondsBetween(*last_, now) : 0;
  last_ = now;
  longest_gap_s_ = std::max(longest_gap_s_, gap_s_);
  if (gap_s_ <= kMissedDeadline * period_s_) return;
  ++missed_;
  if (noted_.has_value() &&
      base::SecondsBetween(*noted_, now) < kDeadlineNote_s) {
    return;
  }
  noted_ = now;
  events_->Add("deadline",
               absl::StrFormat("a step came %.0f ms after the last one instead "
                               "of %.0f ms; %d were late so far",
                               1e3 * gap_s_, 1e3 * period_s_, missed_));
}

std::optional<StopReason> DeadlineMonitor::Problem() const {
  if (gap_s_ < late_s_) return std::nullopt;
  return StopReason{.cause = core::NavigationCause::kControlLate,
                    .text = absl::StrFormat(
                        "the control loop stood still for %.2f s", gap_s_)};
}

}  // namespace treeline::behavior
