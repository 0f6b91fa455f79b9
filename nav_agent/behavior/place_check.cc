#include "nav_agent/behavior/place_check.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/relocalization_parts.h"
#include "nav_agent/behavior/relocalization_states.h"

namespace treeline::behavior {
namespace {

double ScoreOrZero(const std::optional<localization::ScanFit>& fit) {
  return fit.has_value() ? localization::FitScore(*fit) : 0;
}

}  // namespace

bool PlaceCheck::Step(const RelocalizationInput& input,
                      const std::shared_ptr<const core::RgbdFrame>& frame,
                      const FixChecker& checker, ServerQuestion& question,
                      RelocalizationTools& tools) {
  if (!question.has_server() || interval_s_ <= 0) return false;
  is_in_trouble_ = input.is_in_trouble;
  if (question.is_open()) {
    const auto answer = question.Take(input.now);
    // A server that does not answer is nobody's business while all is well.
    return answer.has_value() && answer->ok() &&
           IsElsewhere(**answer, question.motion(), input.now, checker, tools);
  }
  if (!IsTime(input, tools.tracker.Pose(), frame.get())) return false;
  const auto motion = tools.tracker.MotionAt(frame->stamp);
  if (!motion.has_value()) return false;
  last_ = input.now;
  question.Ask(frame, *motion, input.now);
  return false;
}

bool PlaceCheck::IsElsewhere(const core::RelocalizationAnswer& answer,
                             const localization::TrackedMotion& asked_motion,
                             base::MonotonicTime now, const FixChecker& checker,
                             RelocalizationTools& tools) {
  const std::optional<localization::TrackedPose> pose = tools.tracker.Pose();
  const std::optional<localization::TrackedMotion> motion =
      tools.tracker.Motion();
  if (!pose.has_value() || !motion.has_value()) return false;
  const GatedFix fix = checker.Check(answer, asked_motion, tools.tracker);
  tools.report.answer = answer;
  tools.report.answer_verdict = absl::StrCat("check: ", FixText(fix));
  if (fix.verdict != FixVerdict::kSure) return false;
  CheckFinding finding =
      CompareWithFix(fix, *pose, *motion, tools.tracker.FitAt(pose->pose),
                     tools.options.alias_margin);
  switch (finding.verdict) {
    case CheckVerdict::kStays:
      break;
    case CheckVerdict::kCorrected:
      tools.report.Note("check", absl::StrCat(finding.text, ": corrected"));
      finding.seen.place =
          tools.map
              ->GroundNear(finding.seen.map_from_base.translation,
                           fix.pose.place.height_m)
              .value_or(fix.pose.place);
      tools.tracker.SetPose(finding.seen, fix.covariance, now).IgnoreError();
      break;
    case CheckVerdict::kElsewhere:
      tools.report.Note("check", absl::StrCat(finding.text, ": looks again"));
      return true;
  }
  return false;
}

bool PlaceCheck::IsDue(base::MonotonicTime now) const {
  const double wait_s =
      is_in_trouble_ ? std::min(interval_s_, kCheckInTrouble_s) : interval_s_;
  return interval_s_ > 0 && last_.has_value() &&
         base::SecondsBetween(*last_, now) >= wait_s;
}

bool PlaceCheck::IsTime(const RelocalizationInput& input,
                        const std::optional<localization::TrackedPose>& pose,
                        const core::RgbdFrame* frame) {
  if (!last_.has_value()) last_ = input.now;
  return IsDue(input.now) && (input.drives_straight || is_in_trouble_) &&
         pose.has_value() && pose->share >= kKnownShare && frame != nullptr &&
         IsFresh(*frame, input.now);
}

void PlaceCheck::Soon(base::MonotonicTime now) {
  const double wait_s = std::max(0.0, interval_s_ - kCheckToldAfter_s);
  last_ = now - std::chrono::duration_cast<base::MonotonicTime::duration>(
                    std::chrono::duration<double>(wait_s));
}

CheckFinding CompareWithFix(
    const GatedFix& fix, const localization::TrackedPose& pose,
    const localization::TrackedMotion& motion,
    const std::optional<localization::ScanFit>& fit_at_pose,
    double alias_margin) {
  const geometry::Rigid2 now_from_frame =
      motion.odom_from_base.Inverse() * fix.motion.odom_from_base;
  CheckFinding finding;
  finding.seen = fix.pose;
  finding.seen.map_from_base =
      fix.pose.map_from_base * now_from_frame.Inverse();
  const geometry::Rigid2& seen = finding.seen.map_from_base;
  const geometry::Rigid2& believed = pose.pose.map_from_base;
  const double off_m = geometry::Norm(seen.translation - believed.translation);
  const double off_rad =
      std::abs(geometry::NormalizedAngle_rad(seen.yaw_rad - believed.yaw_rad));
  const auto deviation = [&](size_t i) {
    return std::sqrt(fix.covariance[i] + pose.covariance[i]);
  };
  const double agree_m =
      std::max(kCheckAgree_m, 3 * std::max(deviation(0), deviation(4)));
  const double agree_rad = std::max(kCheckAgree_rad, 3 * deviation(8));
  const bool same_level = std::abs(finding.seen.place.height_m -
                                   pose.pose.place.height_m) < kMaxDrift_m;
  if (same_level && off_m <= agree_m && off_rad <= agree_rad) return finding;
  finding.text = absl::StrFormat(
      "the server sees the robot %.2f m and %.0f degrees from where it thinks "
      "it is",
      off_m, InDegrees(off_rad));
  const double gain = ScoreOrZero(fix.fit) - ScoreOrZero(fit_at_pose);
  const bool is_drift = same_level && off_m <= std::max(kMaxDrift_m, agree_m) &&
                        off_rad <= kMaxDrift_rad;
  if (is_drift) {
    if (gain >= kMinCorrectionGain) finding.verdict = CheckVerdict::kCorrected;
  } else if (gain >= -alias_margin) {
    // A place where scans fit clearly worse is not where it is.
    finding.verdict = CheckVerdict::kElsewhere;
  }
  return finding;
}

}  // namespace treeline::behavior
