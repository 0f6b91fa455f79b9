// While the robot drives and knows its place: what the server says of it. And
// while it has given up: whether a server knows it now.
#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "nav_agent/behavior/recovery.h"
#include "nav_agent/behavior/recovery_parts.h"

namespace treeline::behavior {
namespace {

// Pictures older than this are not asked about (s).
constexpr double kFresh_s = 0.2;
constexpr double kKnown = 0.8;
// What a person says is checked so soon (s).
constexpr double kCheckTold_s = 2;
// Within three standard deviations of both, and at least this, they agree.
constexpr double kAgree_m = 0.25;
constexpr double kAgree_rad = 0.12;
// A drift; beyond that one of them is wrong.
constexpr double kDrift_m = 0.8;
constexpr double kDrift_rad = 0.35;
// Scans must fit better by this share of the beams for a correction.
constexpr double kBetter = 0.03;

double ScoreOfFit(
    const std::optional<localization::RobotTracker::ScanFit>& fit) {
  return fit.has_value() ? ScoreOf(*fit) : 0;
}

}  // namespace

void Recovery::Idle(const RecoveryInput& input) {
  if (tracker_.verdict().state == localization::LostState::kLost) {
    Begin(RecoveryCause::kVerdict, input.now);
    return;
  }
  if (server_ == nullptr || options_.check_interval_s <= 0) return;
  if (!is_checking_) {
    BeginCheck(input);
    return;
  }
  const std::optional<Answer> answer = AnswerBy(input.now);
  if (!answer.has_value()) return;
  is_checking_ = false;
  // A server that does not answer is nobody's business while all is well.
  if (answer->ok()) EndCheck(**answer, input.now);
}

bool Recovery::WantsPictures(base::MonotonicTime now) const {
  if (state_ == RecoveryState::kLooking) return true;
  if (state_ == RecoveryState::kNeedHelp) {
    return server_ != nullptr && options_.help_interval_s > 0 && !asks_ &&
           SecondsBetween(*last_help_, now) >= options_.help_interval_s;
  }
  return !IsActive() && server_ != nullptr && options_.check_interval_s > 0 &&
         !is_checking_ && last_check_.has_value() &&
         SecondsBetween(*last_check_, now) >= options_.check_interval_s;
}

void Recovery::Helpless(base::MonotonicTime now) {
  if (server_ == nullptr || options_.help_interval_s <= 0) return;
  if (asks_) {
    const std::optional<Answer> answer = AnswerBy(now);
    if (!answer.has_value()) return;
    asks_ = false;
    if (answer->ok()) Judge(**answer, now);
    return;
  }
  if (SecondsBetween(*last_help_, now) < options_.help_interval_s ||
      frame_ == nullptr || SecondsBetween(frame_->stamp, now) > kFresh_s) {
    return;
  }
  const std::optional<localization::TrackedMotion> motion =
      tracker_.MotionAt(frame_->stamp);
  if (!motion.has_value()) return;
  last_help_ = now;
  // Of the same view as the one before: two of them say no more than one.
  waiting_.clear();
  server_is_useless_ = false;
  failures_ = 0;
  questions_ = 1;
  Ask(*motion, now);
}

void Recovery::CheckSoon(base::MonotonicTime now) {
  const double wait_s = std::max(0.0, options_.check_interval_s - kCheckTold_s);
  last_check_ = now - std::chrono::duration_cast<base::MonotonicTime::duration>(
                          std::chrono::duration<double>(wait_s));
}

void Recovery::BeginCheck(const RecoveryInput& input) {
  if (!last_check_.has_value()) last_check_ = input.now;
  const auto age_s = [&input](base::MonotonicTime then) {
    return std::chrono::duration<double>(input.now - then).count();
  };
  const std::optional<localization::TrackedPose> pose = tracker_.Pose();
  if (!input.drives_straight || !pose.has_value() || pose->share < kKnown ||
      age_s(*last_check_) < options_.check_interval_s || frame_ == nullptr ||
      age_s(frame_->stamp) > kFresh_s) {
    return;
  }
  const std::optional<localization::TrackedMotion> motion =
      tracker_.MotionAt(frame_->stamp);
  if (!motion.has_value()) return;
  last_check_ = input.now;
  is_checking_ = true;
  Ask(*motion, input.now);
}

void Recovery::EndCheck(const core::RelocalizationAnswer& answer,
                        base::MonotonicTime now) {
  const std::optional<localization::TrackedPose> pose = tracker_.Pose();
  const std::optional<localization::TrackedMotion> motion = tracker_.Motion();
  if (!pose.has_value() || !motion.has_value()) return;
  const GatedFix fix = gate_.Check(answer, *asked_motion_, tracker_);
  answer_ = answer;
  answer_verdict_ = absl::StrCat("check: ", FixVerdictName(fix.verdict),
                                 fix.why.empty() ? "" : ": ", fix.why);
  if (fix.verdict != FixVerdict::kSure) return;
  const geometry::Rigid2 now_from_frame =
      motion->odom_from_base.Inverse() * fix.motion.odom_from_base;
  core::LevelPose seen = fix.pose;
  seen.map_from_base = fix.pose.map_from_base * now_from_frame.Inverse();
  const double off_m = geometry::Norm(seen.map_from_base.translation -
                                      pose->pose.map_from_base.translation);
  const double off_rad = std::abs(geometry::NormalizedAngle_rad(
      seen.map_from_base.yaw_rad - pose->pose.map_from_base.yaw_rad));
  const auto deviation = [&](size_t i) {
    return std::sqrt(fix.covariance[i] + pose->covariance[i]);
  };
  const double agree_m =
      std::max(kAgree_m, 3 * std::max(deviation(0), deviation(4)));
  const double agree_rad = std::max(kAgree_rad, 3 * deviation(8));
  const bool same_level =
      std::abs(seen.place.height_m - pose->pose.place.height_m) < kDrift_m;
  if (same_level && off_m <= agree_m && off_rad <= agree_rad) return;
  const double better =
      ScoreOfFit(fix.fit) - ScoreOfFit(tracker_.FitAt(pose->pose));
  const std::string text = absl::StrFormat(
      "the server sees the robot %.2f m and %.0f degrees from where it thinks "
      "it is",
      off_m, off_rad * 57.29577951308232);
  if (same_level && off_m <= std::max(kDrift_m, agree_m) &&
      off_rad <= kDrift_rad) {
    if (better < kBetter) return;
    Note("check", absl::StrCat(text, ": corrected"));
    seen.place = map_->GroundNear(seen.map_from_base.translation,
                                  fix.pose.place.height_m)
                     .value_or(fix.pose.place);
    tracker_.SetPose(seen, fix.covariance, now).IgnoreError();
    return;
  }
  // A place where scans fit clearly worse is not where it is.
  if (better < -options_.alias_margin) return;
  Note("check", absl::StrCat(text, ": looks again"));
  Begin(RecoveryCause::kCheck, now);
}

}  // namespace treeline::behavior
