#include "nav_agent/behavior/fix_gate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"

namespace treeline::behavior {
namespace {

constexpr double kDegrees = 57.29577951308232;
// A fix is never better known than this, nor is a covariance believed that says
// more than the second.
constexpr double kLeastStd_m = 0.08;
constexpr double kLeastStd_rad = 0.04;
constexpr double kMostStd_m = 0.3;
constexpr double kMostStd_rad = 0.15;
// Two places are the same within this.
constexpr double kSame_m = 0.5;
constexpr double kSame_rad = 0.35;
// A fix must not fit worse than the place that the robot thought it was at by
// more than the first; it is weak from the second on.
constexpr double kMuchWorse = 0.25;
constexpr double kWorse = 0.08;
// Each metre that a fix is moved to fit better must be worth this share of the
// beams, each radian that.
constexpr double kPerMetre = 0.2;
constexpr double kPerRadian = 0.5;

bool AreNumbers(const core::RelocalizationAnswer& answer) {
  const geometry::Rotation3& q = answer.map_from_camera.rotation;
  const double norm = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  if (!geometry::IsFinite(answer.map_from_camera) ||
      !(std::abs(norm - 1) < 0.01) ||
      !(answer.confidence >= 0 && answer.confidence <= 1)) {
    return false;
  }
  for (size_t i = 0; i < answer.covariance.size(); ++i) {
    if (!std::isfinite(answer.covariance[i])) return false;
    if (i % 7 == 0 && answer.covariance[i] < 0) return false;
  }
  return true;
}

localization::PoseCovariance2 CovarianceOf(const geometry::PoseCovariance& c) {
  const auto variance = [](double value, double least, double most) {
    return std::clamp(value, least * least, most * most);
  };
  return {variance(c[0], kLeastStd_m, kMostStd_m),     0, 0, 0,
          variance(c[7], kLeastStd_m, kMostStd_m),     0, 0, 0,
          variance(c[35], kLeastStd_rad, kMostStd_rad)};
}

double ScoreOf(const localization::RobotTracker::ScanFit& fit) {
  return fit.explained - fit.contradicted;
}

// The place of the best fit within `step` of one, in nine positions and three
// headings.
struct FittedPose {
  core::LevelPose pose;
  localization::RobotTracker::ScanFit fit;
  double score = -1e9;
};

void TryAround(const localization::RobotTracker& tracker,
               const geometry::Rigid2& begin, double step_m, double step_rad,
               FittedPose& best) {
  const core::LevelPose middle = best.pose;
  for (int i = 0; i < 27; ++i) {
    const double x = i % 3 - 1;
    const double y = (i / 3) % 3 - 1;  // NOLINT(bugprone-integer-division)
    const double turn = i / 9 - 1;     // NOLINT(bugprone-integer-division)
    core::LevelPose pose = middle;
    pose.map_from_base.translation = middle.map_from_base.translation +
                                     geometry::Vec2{step_m * x, step_m * y};
    pose.map_from_base.yaw_rad = geometry::NormalizedAngle_rad(
        middle.map_from_base.yaw_rad + step_rad * turn);
    const auto fit = tracker.FitAt(pose);
    if (!fit.has_value()) continue;
    const double moved_m =
        geometry::Norm(pose.map_from_base.translation - begin.translation);
    const double turned_rad = std::abs(geometry::NormalizedAngle_rad(
        pose.map_from_base.yaw_rad - begin.yaw_rad));
    const double score =
        ScoreOf(*fit) - kPerMetre * moved_m - kPerRadian * turned_rad;
    if (score > best.score + 1e-9) best = {pose, *fit, score};
  }
}

bool AreSame(const core::LevelPose& a, const core::LevelPose& b) {
  return geometry::Norm(a.map_from_base.translation -
                        b.map_from_base.translation) < kSame_m &&
         std::abs(geometry::NormalizedAngle_rad(
             a.map_from_base.yaw_rad - b.map_from_base.yaw_rad)) < kSame_rad &&
         std::abs(a.place.height_m - b.place.height_m) < kSame_m;
}

// The angle between a fix's idea of "up" and the inertial sensor's.
double TiltError_rad(const geometry::Rotation3& map_from_base,
                     const geometry::Rotation3& level_from_base) {
  const geometry::Vec3 up_of_fix =
      map_from_base.Inverse() * geometry::Vec3{0, 0, 1};
  const geometry::Vec3 up = level_from_base.Inverse() * geometry::Vec3{0, 0, 1};
  return std::acos(std::clamp(geometry::Dot(up_of_fix, up), -1.0, 1.0));
}

}  // namespace

absl::Status FixGateOptions::Validate() const {
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: least_confidence", least_confidence, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("gate: sure_confidence", sure_confidence,
                                      least_confidence, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: most_tilt_rad", most_tilt_rad, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: most_height_m", most_height_m, 0, 2));
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: least_clearance_m", least_clearance_m, 0, 2));
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: least_explained", least_explained, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: most_contradicted", most_contradicted, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("gate: sure_explained", sure_explained,
                                      least_explained, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("gate: sure_contradicted",
                                      sure_contradicted, 0, most_contradicted));
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: least_judged", least_judged, 0, 10000));
  TL_RETURN_IF_ERROR(base::CheckRange("gate: search_m", search_m, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("gate: search_rad", search_rad, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("gate: pair_m", pair_m, 0, 2));
  return base::CheckRange("gate: pair_rad", pair_rad, 0, 1);
}

const char* FixVerdictName(FixVerdict verdict) {
  switch (verdict) {
    case FixVerdict::kSure:
      return "sure";
    case FixVerdict::kWeak:
      return "weak";
    case FixVerdict::kNotLocalized:
      return "not localized";
    case FixVerdict::kBroken:
      return "not numbers";
    case FixVerdict::kLowConfidence:
      return "low confidence";
    case FixVerdict::kAgainstGravity:
      return "against gravity";
    case FixVerdict::kNotOnGround:
      return "not on free ground";
    case FixVerdict::kAgainstScan:
      return "against the scan";
  }
  return "?";
}

GatedFix FixGate::Check(const core::RelocalizationAnswer& answer,
                        const localization::TrackedMotion& motion,
                        const localization::RobotTracker& tracker) const {
  GatedFix fix;
  fix.motion = motion;
  fix.confidence = answer.confidence;
  const double p = std::clamp(answer.confidence, 0.01, 0.99);
  fix.log_odds = std::log(p / (1 - p));
  fix.is_server_sure =
      answer.confidence >=
      std::max(options_.sure_confidence, answer.confidence_threshold);
  const auto refuse = [&fix](FixVerdict verdict, std::string why) {
    fix.verdict = verdict;
    fix.why = std::move(why);
    return fix;
  };
  if (!answer.localized) {
    return refuse(FixVerdict::kNotLocalized, answer.reason);
  }
  if (!AreNumbers(answer)) {
    return refuse(FixVerdict::kBroken,
                  "pose, covariance or confidence are not what they may be");
  }
  if (answer.confidence < options_.least_confidence) {
    return refuse(FixVerdict::kLowConfidence,
                  absl::StrFormat("%.2f, needs %.2f", answer.confidence,
                                  options_.least_confidence));
  }
  const geometry::Rigid3 map_from_base =
      answer.map_from_camera * robot_.base_from_camera.Inverse();
  const double tilt_rad =
      TiltError_rad(map_from_base.rotation, motion.level_from_base);
  if (!(tilt_rad <= options_.most_tilt_rad)) {
    return refuse(FixVerdict::kAgainstGravity,
                  absl::StrFormat("leans %.1f degrees otherwise than the "
                                  "inertial sensor says",
                                  tilt_rad * kDegrees));
  }
  return CheckPlace(map_from_base, answer, tracker, std::move(fix));
}

GatedFix FixGate::CheckPlace(const geometry::Rigid3& map_from_base,
                             const core::RelocalizationAnswer& answer,
                             const localization::RobotTracker& tracker,
                             GatedFix fix) const {
  const geometry::Vec3& at = map_from_base.translation;
  const geometry::Vec3 ahead = map_from_base.rotation * geometry::Vec3{1, 0, 0};
  fix.pose.map_from_base = {{at.x, at.y}, std::atan2(ahead.y, ahead.x)};
  fix.covariance = CovarianceOf(answer.covariance);
  std::optional<core::LevelPlace> ground;
  for (int level = 0; level < map_->levels(); ++level) {
    const auto place = map_->GroundOf({at.x, at.y}, level);
    if (!place.has_value() ||
        map_->Clearance_m(level, {at.x, at.y}) < options_.least_clearance_m) {
      continue;
    }
    if (!ground.has_value() ||
        std::abs(place->height_m - at.z) < std::abs(ground->height_m - at.z)) {
      ground = place;
    }
  }
  if (!ground.has_value()) {
    fix.verdict = FixVerdict::kNotOnGround;
    fix.why =
        absl::StrFormat("no room for the robot at %.2f, %.2f", at.x, at.y);
    return fix;
  }
  if (std::abs(ground->height_m - at.z) > options_.most_height_m) {
    fix.verdict = FixVerdict::kNotOnGround;
    fix.why = absl::StrFormat("%.2f m %s the ground",
                              std::abs(at.z - ground->height_m),
                              at.z > ground->height_m ? "above" : "below");
    return fix;
  }
  fix.pose.place = *ground;
  return CheckScan(tracker, std::move(fix));
}

GatedFix FixGate::CheckScan(const localization::RobotTracker& tracker,
                            GatedFix fix) const {
  // From the frame's moment to the scan's, by the wheels.
  geometry::Rigid2 frame_from_scan;
  if (const auto stamp = tracker.ScanStamp(); stamp.has_value()) {
    if (const auto then = tracker.MotionAt(*stamp); then.has_value()) {
      frame_from_scan =
          fix.motion.odom_from_base.Inverse() * then->odom_from_base;
    }
  }
  FittedPose best;
  best.pose = fix.pose;
  best.pose.map_from_base = fix.pose.map_from_base * frame_from_scan;
  const geometry::Rigid2 begin = best.pose.map_from_base;
  const auto here = tracker.FitAt(best.pose);
  if (!here.has_value()) {
    fix.verdict = FixVerdict::kWeak;
    fix.why = "there is no scan to compare with";
    return fix;
  }
  best.fit = *here;
  best.score = ScoreOf(*here);
  TryAround(tracker, begin, options_.search_m * 2 / 3,
            options_.search_rad * 2 / 3, best);
  TryAround(tracker, begin, options_.search_m / 3, options_.search_rad / 3,
            best);
  fix.fit = best.fit;
  fix.pose.map_from_base = best.pose.map_from_base * frame_from_scan.Inverse();
  fix.why = absl::StrFormat(
      "confidence %.2f; the map explains %.2f and contradicts %.2f of %d beams",
      fix.confidence, best.fit.explained, best.fit.contradicted,
      best.fit.judged);
  if (best.fit.judged < options_.least_judged) {
    fix.verdict = FixVerdict::kWeak;
    return fix;
  }
  if (best.fit.explained < options_.least_explained ||
      best.fit.contradicted > options_.most_contradicted) {
    fix.verdict = FixVerdict::kAgainstScan;
    return fix;
  }
  const bool is_sure = fix.is_server_sure &&
                       best.fit.explained >= options_.sure_explained &&
                       best.fit.contradicted <= options_.sure_contradicted;
  fix.verdict = is_sure ? FixVerdict::kSure : FixVerdict::kWeak;
  CompareWithBefore(tracker, best.pose, ScoreOf(best.fit), fix);
  return fix;
}

void FixGate::CompareWithBefore(const localization::RobotTracker& tracker,
                                const core::LevelPose& fitted, double score,
                                GatedFix& fix) const {
  const auto stamp = tracker.ScanStamp();
  const auto before = stamp.has_value() ? tracker.PoseAt(*stamp) : std::nullopt;
  if (!before.has_value() || AreSame(before->pose, fitted)) return;
  const auto fit = tracker.FitAt(before->pose);
  if (!fit.has_value() || fit->judged < options_.least_judged) return;
  const double worse = ScoreOf(*fit) - score;
  if (worse <= kWorse) return;
  fix.verdict =
      worse > kMuchWorse ? FixVerdict::kAgainstScan : FixVerdict::kWeak;
  absl::StrAppend(
      &fix.why, "; where it thought it was fits better, ",
      absl::StrFormat("%.2f and %.2f", fit->explained, fit->contradicted));
}

bool FixGate::Agree(const GatedFix& first, const GatedFix& second) const {
  const geometry::Rigid2 expected =
      first.pose.map_from_base *
      (first.motion.odom_from_base.Inverse() * second.motion.odom_from_base);
  const geometry::Rigid2& seen = second.pose.map_from_base;
  const double off_m = geometry::Norm(expected.translation - seen.translation);
  const double off_rad =
      std::abs(geometry::NormalizedAngle_rad(expected.yaw_rad - seen.yaw_rad));
  const auto deviation = [&](size_t i) {
    return std::sqrt(first.covariance[i] + second.covariance[i]);
  };
  // Floors of the covariances are wide enough; what is beyond is counted once.
  const double sigma_m = std::max(
      0.0, std::max(deviation(0), deviation(4)) - std::sqrt(2.0) * kLeastStd_m);
  const double sigma_rad =
      std::max(0.0, deviation(8) - std::sqrt(2.0) * kLeastStd_rad);
  return off_m <= options_.pair_m + 2 * sigma_m &&
         off_rad <= options_.pair_rad + 2 * sigma_rad &&
         std::abs(first.pose.place.height_m - second.pose.place.height_m) <
             kSame_m + options_.pair_m;
}

}  // namespace treeline::behavior
