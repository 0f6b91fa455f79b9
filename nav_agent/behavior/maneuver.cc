#include "nav_agent/behavior/maneuver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/base/clock.h"
#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {
namespace {

// Round and round while the budget lasts.
using Order = std::array<RecoveryBehaviorKind, 5>;
// Who turns among people may turn into one: what was seen is waited for.
constexpr Order kNoWayOrder = {
    RecoveryBehaviorKind::kWait, RecoveryBehaviorKind::kBackUp,
    RecoveryBehaviorKind::kClearCostmap, RecoveryBehaviorKind::kWait,
    RecoveryBehaviorKind::kBackUp};
constexpr Order kStuckOrder = {
    RecoveryBehaviorKind::kClearCostmap, RecoveryBehaviorKind::kBackUp,
    RecoveryBehaviorKind::kReroute, RecoveryBehaviorKind::kLookAround,
    RecoveryBehaviorKind::kWait};
constexpr Order kEnclosedOrder = {
    RecoveryBehaviorKind::kClearCostmap, RecoveryBehaviorKind::kWait,
    RecoveryBehaviorKind::kBackUp, RecoveryBehaviorKind::kLookAround,
    RecoveryBehaviorKind::kWait};

// It stands; what the costmap remembers and nothing sees any more is forgotten.
constexpr Order kOccupiedOrder = {
    RecoveryBehaviorKind::kWait, RecoveryBehaviorKind::kClearCostmap,
    RecoveryBehaviorKind::kWait, RecoveryBehaviorKind::kClearCostmap,
    RecoveryBehaviorKind::kWait};

const Order& OrderFor(Trouble trouble) {
  switch (trouble) {
    case Trouble::kOccupied:
      return kOccupiedOrder;
    case Trouble::kStuck:
      return kStuckOrder;
    case Trouble::kEnclosed:
      return kEnclosedOrder;
    case Trouble::kNoWay:
      break;
  }
  return kNoWayOrder;
}

}  // namespace

const char* RecoveryBehaviorName(RecoveryBehaviorKind kind) {
  switch (kind) {
    case RecoveryBehaviorKind::kClearCostmap:
      return "clear costmap";
    case RecoveryBehaviorKind::kBackUp:
      return "back up";
    case RecoveryBehaviorKind::kLookAround:
      return "look around";
    case RecoveryBehaviorKind::kWait:
      return "wait";
    case RecoveryBehaviorKind::kReroute:
      return "re-route";
  }
  return "unknown";
}

const char* RecoveryBehaviorOutcomeName(RecoveryBehaviorOutcome outcome) {
  switch (outcome) {
    case RecoveryBehaviorOutcome::kRunning:
      return "running";
    case RecoveryBehaviorOutcome::kDone:
      return "done";
    case RecoveryBehaviorOutcome::kNotPossible:
      return "not possible";
    case RecoveryBehaviorOutcome::kTimedOut:
      return "timed out";
  }
  return "unknown";
}

RecoveryBehavior::RecoveryBehavior(const RecoverySequenceStep& rung,
                                   const NavigatorLimits& limits,
                                   base::MonotonicTime now)
    : rung_(rung), limits_(limits), begun_(now) {}

RecoveryBehavior::Result RecoveryBehavior::Step(
    const control::ControlPose& pose, base::MonotonicTime now,
    control::LocalController& controller) {
  const double elapsed_s = base::SecondsBetween(begun_, now);
  switch (rung_.kind) {
    case RecoveryBehaviorKind::kClearCostmap:
      controller.ClearObstacles();
      return {.outcome = RecoveryBehaviorOutcome::kDone, .command = {}};
    case RecoveryBehaviorKind::kBackUp:
      return BackUp(pose, now, controller);
    case RecoveryBehaviorKind::kLookAround:
      return LookAround(pose, elapsed_s, controller);
    case RecoveryBehaviorKind::kWait:
      return {.outcome = elapsed_s >= rung_.wait_s
                             ? RecoveryBehaviorOutcome::kDone
                             : RecoveryBehaviorOutcome::kRunning,
              .command = {}};
    case RecoveryBehaviorKind::kReroute:
      break;
  }
  // Who began it knows what is ahead.
  return {.outcome = RecoveryBehaviorOutcome::kDone, .command = {}};
}

RecoveryBehavior::Result RecoveryBehavior::BackUp(
    const control::ControlPose& pose, base::MonotonicTime now,
    control::LocalController& controller) {
  const geometry::Rigid2& here = pose.pose.map_from_base;
  // Whoever is about may come up behind it: the bold wait for a quiet moment.
  const double quiet_s = controller.QuietFor_s(now);
  if (!start_.has_value() &&
      quiet_s < (rung_.is_bold ? kQuietMoment_s : kNobodyMovedFor_s)) {
    const bool waits =
        rung_.is_bold && base::SecondsBetween(begun_, now) < limits_.back_up_s;
    return {.outcome = waits ? RecoveryBehaviorOutcome::kRunning
                             : RecoveryBehaviorOutcome::kNotPossible,
            .command = controller.Guard(pose, {})};
  }
  if (quiet_s < kSomebodyMoves_s) {
    return {.outcome = RecoveryBehaviorOutcome::kTimedOut, .command = {}};
  }
  if (!start_.has_value()) {
    begun_ = now;
    start_ = here;
    // Where nothing is known to be in the way, to a hand's breadth.
    way_m_ = controller.FreeWay_m(pose, -limits_.back_up_m);
    if (std::abs(way_m_) < kMinBackUp_m) {
      return {.outcome = RecoveryBehaviorOutcome::kNotPossible, .command = {}};
    }
  }
  const double done_m = geometry::Norm(here.translation - start_->translation);
  if (done_m >= std::abs(way_m_) - kBackUpTolerance_m) {
    return {.outcome = RecoveryBehaviorOutcome::kDone, .command = {}};
  }
  if (base::SecondsBetween(begun_, now) > limits_.back_up_s) {
    return {.outcome = RecoveryBehaviorOutcome::kTimedOut, .command = {}};
  }
  return {
      .outcome = RecoveryBehaviorOutcome::kRunning,
      .command = controller.Guard(
          pose, {.forward_mps = -limits_.back_up_mps, .yaw_rate_radps = 0})};
}

RecoveryBehavior::Result RecoveryBehavior::LookAround(
    const control::ControlPose& pose, double elapsed_s,
    control::LocalController& controller) {
  const geometry::Rigid2& here = pose.pose.map_from_base;
  if (!start_.has_value()) {
    start_ = here;
    last_yaw_rad_ = here.yaw_rad;
    // Slopes have edges.
    if (geometry::AngleBetween_rad(pose.level_from_base, {}) >
            kLevelGround_rad ||
        !controller.CanTurn(pose)) {
      return {.outcome = RecoveryBehaviorOutcome::kNotPossible, .command = {}};
    }
  }
  turned_rad_ += geometry::NormalizedAngle_rad(here.yaw_rad - last_yaw_rad_);
  last_yaw_rad_ = here.yaw_rad;
  if (turned_rad_ >= 2 * std::numbers::pi - kTurnTolerance_rad) {
    return {.outcome = RecoveryBehaviorOutcome::kDone, .command = {}};
  }
  if (elapsed_s > limits_.look_s) {
    return {.outcome = RecoveryBehaviorOutcome::kTimedOut, .command = {}};
  }
  return {.outcome = RecoveryBehaviorOutcome::kRunning,
          .command = controller.Guard(
              pose, {.forward_mps = 0, .yaw_rate_radps = limits_.look_radps})};
}

std::optional<RecoverySequenceStep> RecoverySequence::Next(Trouble trouble) {
  if (used_ >= limits_.max_recoveries) return std::nullopt;
  const Order& order = OrderFor(trouble);
  const size_t at = static_cast<size_t>(used_) % order.size();
  // All rungs count, so that waits grow as the budget shrinks.
  const double wait_s = std::min(
      limits_.longest_wait_s,
      limits_.first_wait_s * std::exp2(static_cast<double>(used_) / 3));
  const bool is_bold = used_ >= kBoldAfter;
  ++used_;
  can_give_back_ = true;
  return RecoverySequenceStep{
      .kind = order[at], .wait_s = wait_s, .is_bold = is_bold};
}

void RecoverySequence::GiveBack() {
  if (!can_give_back_ || used_ < 1 || given_back_ >= kMaxGivenBack) return;
  can_give_back_ = false;
  --used_;
  ++given_back_;
}

}  // namespace treeline::behavior
