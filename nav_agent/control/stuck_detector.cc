#include "nav_agent/control/stuck_detector.h"

#include <chrono>
#include <cmath>

namespace treeline::control {
namespace {

double Since_s(const std::optional<base::MonotonicTime>& from,
               base::MonotonicTime now) {
  return from.has_value() ? std::chrono::duration<double>(now - *from).count()
                          : 0;
}

}  // namespace

void StuckDetector::Reset() { *this = StuckDetector(options_); }

bool StuckDetector::IsStuck(const StuckDetectorInput& input) {
  const bool has_moved =
      !moved_at_.has_value() ||
      geometry::Norm(input.at.translation - moved_to_.translation) >
          options_.progress_m ||
      std::abs(geometry::NormalizedAngle_rad(
          input.at.yaw_rad - moved_to_.yaw_rad)) > options_.progress_rad;
  if (has_moved || !input.wants_to_move) {
    moved_at_ = input.stamp;
    moved_to_ = input.at;
  }
  return Since_s(moved_at_, input.stamp) > options_.stuck_s;
}

ControlState StuckDetector::Judge(const StuckDetectorInput& input) {
  const ControlState state = Decide(input);
  holds_ = state == ControlState::kWaiting ||
           (input.is_broken && state != ControlState::kDriving);
  return state;
}

ControlState StuckDetector::Decide(const StuckDetectorInput& input) {
  const bool is_stuck = IsStuck(input);
  // Nothing is seen that hinders it, and yet it does not move.
  const bool is_held =
      is_stuck && Since_s(moved_at_, input.stamp) > options_.held_s;
  const bool is_hindered =
      input.is_broken || (is_stuck && input.is_guarded) || is_held;
  if (!is_hindered) {
    if (!whole_since_.has_value()) whole_since_ = input.stamp;
    if (Since_s(whole_since_, input.stamp) >= options_.mended_s) {
      broken_since_.reset();
      waiting_since_.reset();
      is_blocked_ = false;
      // An escape goes on until the robot has got away.
      if (!is_stuck && Since_s(escaping_since_, input.stamp) > kEscapeAhead_s) {
        escaping_since_.reset();
        wants_escape_ = false;
      }
    }
    return is_blocked_ ? ControlState::kBlocked : ControlState::kDriving;
  }
  whole_since_.reset();
  if (!broken_since_.has_value()) broken_since_ = input.stamp;
  if (is_blocked_) return ControlState::kBlocked;
  const double hindered_s = Since_s(broken_since_, input.stamp);
  if (hindered_s < options_.break_s && !is_stuck) {
    return ControlState::kDriving;
  }
  // What came a moment ago may go again.
  if (input.obstacle_age_s < options_.young_s || waiting_since_.has_value()) {
    if (!waiting_since_.has_value()) waiting_since_ = input.stamp;
    if (Since_s(waiting_since_, input.stamp) < options_.patience_s) {
      return ControlState::kWaiting;
    }
  }
  if (!input.is_broken) {
    if (!escaping_since_.has_value()) escaping_since_ = input.stamp;
    wants_escape_ = true;
    if (Since_s(escaping_since_, input.stamp) < options_.escape_s) {
      return ControlState::kDriving;
    }
  }
  is_blocked_ = true;
  wants_escape_ = false;
  return ControlState::kBlocked;
}

}  // namespace treeline::control
