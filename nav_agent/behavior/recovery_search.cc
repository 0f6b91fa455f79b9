// Without a server: what the laser says of itself, or else AMCL that looks
// everywhere while the robot turns and moves.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "nav_agent/behavior/recovery.h"
#include "nav_agent/behavior/recovery_parts.h"

namespace treeline::behavior {
namespace {

constexpr double kCircle_rad = 2 * std::numbers::pi;
// A move is at least and at most so long, and ends this far from what is ahead.
constexpr double kLeastMove_m = 0.3;
constexpr double kMostMove_m = 1.5;
constexpr double kKeepAway_m = 0.3;
constexpr double kFaced_rad = 0.1;
// No leg takes longer: something holds the robot (s).
constexpr double kMostLeg_s = 15;
// It pauses so often for a picture, and if the server failed last (s).
constexpr double kAskEvery_s = 4;
constexpr double kAskFailedEvery_s = 15;
// Of the scans while a place holds, so many may not fit: somebody walks by.
constexpr double kMostBadShare = 0.2;
constexpr int kFreeBadScans = 2;
// A scan is another one after such a turn.
constexpr double kLookAgain_rad = 0.5;
// Where it came from is half as good.
constexpr double kBackWorth = 0.5;

}  // namespace

void Recovery::BeginSearch(base::MonotonicTime now) {
  search_began_ = now;
  last_pause_ = now;
  searches_anywhere_ = false;
  BreakHold();
  alias_ = Alias::kNotLooked;
  seed_.reset();
  last_yaw_rad_.reset();
  cycle_turned_rad_ = 0;
  best_free_m_ = 0;
  leg_ = Leg::kTurn;
  cycles_ = 0;
  holds_clear_ = false;
  Go(RecoveryState::kSearching, now);
  if (MayTryClear() && TryClear(now)) return;
  // Nobody was asked, so nobody has looked over the map yet.
  if (look_ == Look::kNone) BeginLook();
  // Where the verdict is not, or no longer, that it is lost, what it knows gets
  // the chance of a full turn.
  if (!tracker_.Pose().has_value() ||
      tracker_.verdict().state == localization::LostState::kLost) {
    LookAnywhere(now);
  }
}

void Recovery::LookAnywhere(base::MonotonicTime now) {
  holds_clear_ = false;
  if (options_.method == RecoveryMethod::kInjectionOnly &&
      tracker_.Pose().has_value()) {
    return;
  }
  tracker_.SetAnywhere(now);
  searches_anywhere_ = true;
  BreakHold();
}

void Recovery::BreakHold() {
  holds_since_.reset();
  hold_turned_rad_ = 0;
  good_scans_ = 0;
  bad_scans_ = 0;
  if (state_ == RecoveryState::kSearching) alias_ = Alias::kNotLooked;
}

bool Recovery::SearchHolds(base::MonotonicTime now) {
  const ScanSays says =
      WatchScan(options_.search_explained, options_.search_contradicted);
  good_scans_ += says == ScanSays::kGood ? 1 : 0;
  bad_scans_ += says == ScanSays::kBad ? 1 : 0;
  const bool is_tight =
      IsPoseTight(options_.search_share, options_.search_std_m) &&
      tracker_.verdict().state != localization::LostState::kLost;
  const bool fits = bad_scans_ <= kFreeBadScans + kMostBadShare * good_scans_;
  if (!is_tight || !fits) {
    BreakHold();
    return false;
  }
  if (!holds_since_.has_value()) {
    if (says != ScanSays::kGood) return false;
    holds_since_ = now;
  }
  const double held_s = SecondsBetween(*holds_since_, now);
  if (held_s < options_.search_hold_s ||
      hold_turned_rad_ < options_.search_hold_rad ||
      tracker_.verdict().probability > 0.2) {
    return false;
  }
  if (alias_ == Alias::kNotLooked) {
    look_ = Look::kNone;
    const std::optional<localization::TrackedPose> pose = tracker_.Pose();
    alias_own_ = tracker_.FitAt(pose->pose)
                     .value_or(localization::RobotTracker::ScanFit());
    tracker_.BeginOtherPlaces(pose->pose);
    alias_ = Alias::kLooking;
    return false;
  }
  if (alias_ == Alias::kLooking) {
    if (!tracker_.StepOtherPlaces()) return false;
    alias_ = AliasFound();
    alias_turned_rad_ = hold_turned_rad_;
    if (alias_ != Alias::kNone) {
      Note("recovery", "the laser fits another place as well: goes on looking");
    }
  } else if (alias_ != Alias::kNone && holds_clear_ &&
             hold_turned_rad_ - alias_turned_rad_ > kLookAgain_rad) {
    // One scan said that it fits nowhere else, another one that it does: a
    // third. Rooms that are alike are so in all of them.
    alias_ = Alias::kNotLooked;
  }
  return alias_ == Alias::kNone;
}

void Recovery::EndCycle(base::MonotonicTime now) {
  ++cycles_;
  const std::optional<localization::TrackedPose> pose = tracker_.Pose();
  // One full turn, and what particles gathered at does not hold.
  const bool is_wrong =
      !holds_since_.has_value() && (!pose.has_value() || !pose->is_searching);
  if (alias_ == Alias::kSome || alias_ == Alias::kBetter) {
    alias_ = Alias::kNotLooked;
  }
  if (holds_clear_ && is_wrong && MayAsk()) {
    // It was not there: the camera's turn again.
    Note("recovery", "what the laser said does not hold: looks elsewhere");
    holds_clear_ = false;
    search_began_.reset();
    LookElsewhere(now);
    return;
  }
  if (!searches_anywhere_ || is_wrong) LookAnywhere(now);
}

bool Recovery::IsTimeToAsk(base::MonotonicTime now) const {
  if (!MayAsk() || asks_) return false;
  const double since_s = SecondsBetween(*last_pause_, now);
  return since_s > (failures_ > 0 ? kAskFailedEvery_s : kAskEvery_s);
}

bool Recovery::TookAnswer(base::MonotonicTime now) {
  if (!asks_) return false;
  const std::optional<Answer> answer = AnswerBy(now);
  if (!answer.has_value()) return false;
  asks_ = false;
  const base::MonotonicTime leg_began = since_;
  if (answer->ok()) {
    Judge(**answer, now);
  } else {
    Failed(answer->status(), now);
  }
  // The legs of the search go on as they were.
  if (state_ == RecoveryState::kSearching) since_ = leg_began;
  return state_ != RecoveryState::kSearching;
}

core::VelocityCommand Recovery::SearchMotion(const RecoveryInput& input) {
  const std::optional<localization::TrackedMotion> motion = tracker_.Motion();
  if (!motion.has_value()) return {};
  const double yaw_rad = motion->odom_from_base.yaw_rad;
  const auto next_leg = [&](Leg leg) {
    leg_ = leg;
    leg_from_ = motion->odom_from_base;
    cycle_turned_rad_ = 0;
    since_ = input.now;
  };
  const bool is_stuck = InState_s(input.now) > kMostLeg_s;
  switch (leg_) {
    case Leg::kTurn: {
      const double back_rad = geometry::NormalizedAngle_rad(
          yaw_rad - leg_from_.yaw_rad - std::numbers::pi);
      const double worth =
          cycles_ > 0 && std::abs(back_rad) < 0.8 ? kBackWorth : 1;
      if (worth * input.free_ahead_m > best_free_m_) {
        best_free_m_ = worth * input.free_ahead_m;
        best_free_yaw_rad_ = yaw_rad;
      }
      if (cycle_turned_rad_ >= kCircle_rad || is_stuck) {
        next_leg(Leg::kFace);
        EndCycle(input.now);
        return {};
      }
      return Swing(input, options_.turn_radps);
    }
    case Leg::kFace:
      if (best_free_m_ < kLeastMove_m + kKeepAway_m || is_stuck) {
        best_free_m_ = 0;
        next_leg(Leg::kTurn);
        return {};
      }
      if (std::abs(geometry::NormalizedAngle_rad(best_free_yaw_rad_ -
                                                 yaw_rad)) > kFaced_rad) {
        return TurnTowards(best_free_yaw_rad_);
      }
      leg_m_ = std::min(kMostMove_m, best_free_m_ - kKeepAway_m);
      next_leg(Leg::kMove);
      return {};
    case Leg::kMove:
      break;
  }
  const double moved_m = geometry::Norm(motion->odom_from_base.translation -
                                        leg_from_.translation);
  if (moved_m >= leg_m_ || input.free_ahead_m < kKeepAway_m || is_stuck) {
    best_free_m_ = 0;
    next_leg(Leg::kTurn);
    return {};
  }
  return {.forward_mps = options_.move_mps, .yaw_rate_radps = 0};
}

core::VelocityCommand Recovery::Searching(const RecoveryInput& input) {
  const std::optional<localization::TrackedMotion> motion = tracker_.Motion();
  if (!motion.has_value()) return {};
  const double yaw_rad = motion->odom_from_base.yaw_rad;
  if (last_yaw_rad_.has_value()) {
    const double turned_rad =
        std::abs(geometry::NormalizedAngle_rad(yaw_rad - *last_yaw_rad_));
    cycle_turned_rad_ += turned_rad;
    hold_turned_rad_ += holds_since_.has_value() ? turned_rad : 0;
  }
  last_yaw_rad_ = yaw_rad;
  if (TookAnswer(input.now)) return {};
  if (SearchHolds(input.now)) {
    Found("by laser alone, and scans fit nowhere else", input.now);
    return {};
  }
  if (SecondsBetween(*search_began_, input.now) > options_.most_search_s) {
    NeedHelp(input.now);
    return {};
  }
  if (IsTimeToAsk(input.now)) {
    last_pause_ = input.now;
    Go(RecoveryState::kStopping, input.now);
    return {};
  }
  return SearchMotion(input);
}

}  // namespace treeline::behavior
