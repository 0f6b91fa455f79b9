#include "nav_agent/behavior/relocalization_states.h"

#include <cmath>

#include "common/base/clock.h"
#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/swing_motion.h"

namespace treeline::behavior {

bool StoppingState::Step(
    const std::optional<localization::TrackedMotion>& motion, double settle_s,
    base::MonotonicTime now) {
  const bool stands =
      motion.has_value() &&
      std::abs(motion->forward_mps) < kStandstillSpeed_mps &&
      std::abs(motion->yaw_rate_radps) < kStandstillYawRate_radps;
  if (!stands) {
    standing_since_.reset();
  } else if (!standing_since_.has_value()) {
    standing_since_ = now;
  }
  const bool has_settled =
      standing_since_.has_value() &&
      base::SecondsBetween(*standing_since_, now) >= settle_s;
  return has_settled || base::SecondsBetween(since_, now) >= kMaxStopping_s;
}

LookingState::Outcome LookingState::Step(const core::RgbdFrame* frame,
                                         base::MonotonicTime now) const {
  if (frame != nullptr && frame->stamp >= since_) return Outcome::kHasPicture;
  return base::SecondsBetween(since_, now) > kCameraTimeout_s
             ? Outcome::kNoPictures
             : Outcome::kWaiting;
}

bool AskingState::HasPatience(base::MonotonicTime now) const {
  return base::SecondsBetween(since_, now) <= kAnswerPatience_s;
}

TurningState::Result TurningState::Step(
    const localization::TrackedMotion& motion, double max_radps,
    base::MonotonicTime now) const {
  const double left_rad = geometry::NormalizedAngle_rad(
      target_rad_ - motion.odom_from_base.yaw_rad);
  const double took_s = base::SecondsBetween(since_, now);
  if (std::abs(left_rad) < kTurnTolerance_rad || took_s > kMaxTurning_s) {
    return {.outcome = Outcome::kThere, .wanted = {}};
  }
  if (took_s > kTurnStart_s &&
      std::abs(motion.yaw_rate_radps) < kStandstillYawRate_radps) {
    return {.outcome = Outcome::kNoRoom, .wanted = {}};
  }
  return {.outcome = Outcome::kTurns,
          .wanted = TurnTowards(target_rad_, motion, max_radps)};
}

bool HelpWait::IsTimeToAsk(double interval_s, base::MonotonicTime now) const {
  return interval_s > 0 && base::SecondsBetween(last_asked_, now) >= interval_s;
}

bool IsFresh(const core::RgbdFrame& frame, base::MonotonicTime now) {
  return base::SecondsBetween(frame.stamp, now) <= kMaxPictureAge_s;
}

}  // namespace treeline::behavior
