// A fix was taken: whether it holds.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "nav_agent/behavior/recovery.h"
#include "nav_agent/behavior/recovery_parts.h"

namespace treeline::behavior {
namespace {

// Of scans: more bad ones end it.
constexpr int kMostBadScans = 12;
// What has not turned enough by then (s), and cannot turn, has no room to.
constexpr double kNoRoom_s = 4;
// The pose must not leave what was seeded by more (m).
constexpr double kMostDrift_m = 0.6;

}  // namespace

void Recovery::Seed(const GatedFix& fix, bool was_seen_twice,
                    base::MonotonicTime now) {
  const std::optional<localization::TrackedMotion> motion = tracker_.Motion();
  if (!motion.has_value()) return;
  const core::LevelPose pose = CarriedOn(fix.pose, fix.motion, *motion, *map_);
  const absl::Status told = tracker_.SetPose(pose, fix.covariance, now);
  if (!told.ok()) {
    Note("fix", absl::StrCat("the fix could not be taken: ",
                             std::string(told.ToString())));
    LookElsewhere(now);
    return;
  }
  was_seeded_ = true;
  seed_ = fix;
  seen_twice_ = was_seen_twice;
  good_scans_ = 0;
  bad_scans_ = 0;
  turned_rad_ = 0;
  last_yaw_rad_.reset();
  scan_ = tracker_.ScanStamp();
  alias_ = Alias::kNotLooked;
  look_ = Look::kNone;
  Note("recovery",
       absl::StrFormat("takes %.2f, %.2f on level %d, %.0f degrees, to see "
                       "whether it holds",
                       pose.map_from_base.translation.x,
                       pose.map_from_base.translation.y, pose.place.level,
                       pose.map_from_base.yaw_rad * 57.29577951308232));
  Go(RecoveryState::kConfirming, now);
}

Recovery::ScanSays Recovery::WatchScan(double explained, double contradicted) {
  const std::optional<base::MonotonicTime> stamp = tracker_.ScanStamp();
  if (!stamp.has_value() || stamp == scan_) return ScanSays::kNothingNew;
  scan_ = stamp;
  const std::optional<localization::TrackedPose> pose = tracker_.PoseAt(*stamp);
  if (!pose.has_value()) return ScanSays::kNothingNew;
  const auto fit = tracker_.FitAt(pose->pose);
  if (!fit.has_value() || fit->judged < options_.gate.least_judged / 2) {
    return ScanSays::kNothingNew;
  }
  return fit->explained >= explained && fit->contradicted <= contradicted
             ? ScanSays::kGood
             : ScanSays::kBad;
}

bool Recovery::IsPoseTight(double share, double std_m) const {
  const std::optional<localization::TrackedPose> pose = tracker_.Pose();
  return pose.has_value() && pose->share >= share && !pose->is_searching &&
         std::sqrt(std::max(pose->covariance[0], pose->covariance[4])) <= std_m;
}

Recovery::Alias Recovery::AliasFound() const {
  const std::vector<localization::RobotTracker::OtherPlace> others =
      tracker_.BestPlaces();
  if (others.empty()) return Alias::kNone;
  const double lead = ScoreOf(others.front().fit) - ScoreOf(alias_own_);
  if (lead > options_.alias_margin) return Alias::kBetter;
  return lead > -options_.alias_margin ? Alias::kSome : Alias::kNone;
}

core::VelocityCommand Recovery::Confirming(const RecoveryInput& input) {
  const std::optional<localization::TrackedMotion> motion = tracker_.Motion();
  const std::optional<localization::TrackedPose> pose = tracker_.Pose();
  if (!motion.has_value() || !pose.has_value()) return {};
  const double yaw_rad = motion->odom_from_base.yaw_rad;
  if (last_yaw_rad_.has_value()) {
    turned_rad_ +=
        std::abs(geometry::NormalizedAngle_rad(yaw_rad - *last_yaw_rad_));
  }
  last_yaw_rad_ = yaw_rad;
  switch (
      WatchScan(options_.confirm_explained, options_.confirm_contradicted)) {
    case ScanSays::kNothingNew:
      break;
    case ScanSays::kGood:
      ++good_scans_;
      break;
    case ScanSays::kBad:
      good_scans_ = 0;
      ++bad_scans_;
      break;
  }
  // Whether the laser alone would know this place from all others.
  if (alias_ == Alias::kNotLooked && good_scans_ > 0) {
    const auto fit = tracker_.FitAt(pose->pose);
    alias_own_ = fit.value_or(localization::RobotTracker::ScanFit());
    tracker_.BeginOtherPlaces(pose->pose);
    alias_ = Alias::kLooking;
  } else if (alias_ == Alias::kLooking && tracker_.StepOtherPlaces()) {
    alias_ = AliasFound();
  }
  const core::LevelPose expected =
      CarriedOn(seed_->pose, seed_->motion, *motion, *map_);
  const double drift_m = geometry::Norm(expected.map_from_base.translation -
                                        pose->pose.map_from_base.translation);
  const localization::LostVerdict& verdict = tracker_.verdict();
  if (alias_ == Alias::kBetter) {
    NotConfirmed("scans fit better elsewhere", input.now);
    return {};
  }
  if (InState_s(input.now) > options_.most_confirm_s) {
    NotConfirmed("it was not confirmed in time", input.now);
    return {};
  }
  if (bad_scans_ > kMostBadScans || drift_m > kMostDrift_m ||
      verdict.state == localization::LostState::kLost) {
    NotConfirmed(drift_m > kMostDrift_m ? "localization went elsewhere"
                                        : "scans do not fit there",
                 input.now);
    return {};
  }
  const bool fits = good_scans_ >= options_.confirm_scans &&
                    IsPoseTight(0.8, 0.3) && verdict.probability < 0.3;
  const bool has_held = fits && turned_rad_ >= options_.confirm_turn_rad;
  // Camera and laser may both be wrong where rooms are alike: what the scan
  // shows somewhere else is waited for, if it could fit better there.
  const bool may_be_elsewhere = alias_ == Alias::kLooking &&
                                ScoreOf(alias_own_) < 1 - options_.alias_margin;
  if (has_held && may_be_elsewhere) return {};
  if (has_held && (seen_twice_ || alias_ == Alias::kNone)) {
    Found(seen_twice_ ? "seen twice, and scans fit"
                      : "seen once, and scans fit nowhere else",
          input.now);
    return {};
  }
  if (has_held && alias_ == Alias::kSome) {
    // Other places look the same to the laser: the camera must say it twice.
    LookAgain("the laser would fit elsewhere too", input.now);
    return {};
  }
  const bool has_no_room =
      fits && !input.can_turn && InState_s(input.now) > kNoRoom_s;
  if (has_no_room && alias_ == Alias::kNone) {
    if (seen_twice_) {
      Found("seen twice, and scans fit nowhere else", input.now);
    } else {
      LookAgain("there is no room to turn", input.now);
    }
    return {};
  }
  if (turned_rad_ >= options_.confirm_turn_rad) return {};
  return Swing(input, 0.6 * options_.turn_radps);
}

void Recovery::LookAgain(const std::string& why, base::MonotonicTime now) {
  if (!MayAsk()) {
    NotConfirmed(why + ", and the server cannot be asked again", now);
    return;
  }
  Note("recovery", why + ": looks a second time");
  waiting_ = {*seed_};
  Go(RecoveryState::kStopping, now);
}

void Recovery::NotConfirmed(const std::string& why, base::MonotonicTime now) {
  Note("recovery", absl::StrCat("not there: ", why));
  answer_verdict_ = absl::StrCat("taken, and not confirmed: ", why);
  waiting_.clear();
  if (seed_.has_value()) {
    belief_.AddAnswer(seed_->motion.odom_from_base.yaw_rad, 0.03);
  }
  seed_.reset();
  if (needs_help_) {
    Go(RecoveryState::kNeedHelp, now);
    return;
  }
  if (search_began_.has_value()) {
    searches_anywhere_ = false;
    cycles_ = 1;
    Go(RecoveryState::kSearching, now);
    return;
  }
  LookElsewhere(now);
}

}  // namespace treeline::behavior
