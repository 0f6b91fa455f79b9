#include "nav_agent/behavior/progress_checker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/clock.h"
#include "nav_agent/behavior/event_log.h"

namespace treeline::behavior {

bool ProgressChecker::Observe(base::MonotonicTime now, size_t leg,
                              double to_go_m, double yaw_rad) {
  if (leg != leg_) {
    leg_ = leg;
    min_to_go_m_ = to_go_m;
    refilled_at_m_ = to_go_m;
    refill_ = true;
    since_.reset();
  }
  if (std::isinf(refilled_at_m_)) refilled_at_m_ = to_go_m;
  min_to_go_m_ = std::min(min_to_go_m_, to_go_m);
  if (refilled_at_m_ - min_to_go_m_ >= limits_.recovery_reset_m) {
    refilled_at_m_ = min_to_go_m_;
    refill_ = true;
  }
  const bool begins = !since_.has_value();
  const bool moved = !begins && to_go_m_ - to_go_m >= limits_.progress_m;
  const bool turned =
      !begins && !has_turned_ &&
      std::abs(geometry::NormalizedAngle_rad(yaw_rad - yaw_rad_)) >=
          limits_.progress_rad;
  if (begins || moved || turned) {
    has_turned_ = turned;
    since_ = now;
    // A turn may lead away from the goal; what counts is where it was before.
    to_go_m_ = turned ? std::min(to_go_m_, to_go_m) : to_go_m;
    yaw_rad_ = yaw_rad;
    return true;
  }
  return base::SecondsBetween(*since_, now) < limits_.progress_s;
}

bool ProgressChecker::TakeRefill() { return std::exchange(refill_, false); }

}  // namespace treeline::behavior
