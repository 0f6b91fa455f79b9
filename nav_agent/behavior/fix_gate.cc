#include "nav_agent/behavior/fix_gate.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "nav_agent/behavior/angle_text.h"
#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {
namespace {

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

FixJudgement Refusal(FixVerdict verdict, std::string why) {
  return {.verdict = verdict, .why = std::move(why)};
}

// What the answer says of itself; nullopt: nothing against it.
std::optional<FixJudgement> RefusalByAnswer(
    const core::RelocalizationAnswer& answer, const FixGateOptions& options) {
  if (!answer.localized) {
    return Refusal(FixVerdict::kNotLocalized, answer.reason);
  }
  if (!AreNumbers(answer)) {
    return Refusal(FixVerdict::kBroken,
                   "pose, covariance or confidence are not what they may be");
  }
  if (answer.confidence < options.min_confidence) {
    return Refusal(FixVerdict::kLowConfidence,
                   absl::StrFormat("%.2f, needs %.2f", answer.confidence,
                                   options.min_confidence));
  }
  return std::nullopt;
}

std::optional<FixJudgement> RefusalByGravity(double tilt_error_rad,
                                             const FixGateOptions& options) {
  // Not a number is refused, too.
  if (tilt_error_rad <= options.max_tilt_rad) return std::nullopt;
  return Refusal(FixVerdict::kAgainstGravity,
                 absl::StrFormat("leans %.1f degrees otherwise than the "
                                 "inertial sensor says",
                                 InDegrees(tilt_error_rad)));
}

std::optional<FixJudgement> RefusalByMap(const GroundWitness& witness,
                                         const FixGateOptions& options) {
  const geometry::Vec3& at = witness.base_in_map;
  if (!witness.ground_m.has_value()) {
    return Refusal(
        FixVerdict::kNotOnGround,
        absl::StrFormat("no room for the robot at %.2f, %.2f", at.x, at.y));
  }
  const double above_m = at.z - *witness.ground_m;
  if (std::abs(above_m) <= options.max_height_error_m) return std::nullopt;
  return Refusal(FixVerdict::kNotOnGround,
                 absl::StrFormat("%.2f m %s the ground", std::abs(above_m),
                                 above_m > 0 ? "above" : "below"));
}

FixJudgement JudgeByScan(const core::RelocalizationAnswer& answer,
                         const ScanWitness& witness,
                         const FixGateOptions& options) {
  if (!witness.at_fix.has_value()) {
    return {.verdict = FixVerdict::kWeak,
            .why = "there is no scan to compare with"};
  }
  const localization::ScanFit& fit = *witness.at_fix;
  FixJudgement judgement = {
      .verdict = FixVerdict::kWeak,
      .why = absl::StrFormat("confidence %.2f; the map explains %.2f and "
                             "contradicts %.2f of %d beams",
                             answer.confidence, fit.explained, fit.contradicted,
                             fit.judged)};
  if (fit.judged < options.min_judged_beams) return judgement;
  if (fit.explained < options.min_explained ||
      fit.contradicted > options.max_contradicted) {
    judgement.verdict = FixVerdict::kAgainstScan;
    return judgement;
  }
  const bool is_sure = IsServerSure(answer, options) &&
                       fit.explained >= options.sure_explained &&
                       fit.contradicted <= options.sure_contradicted;
  if (is_sure) judgement.verdict = FixVerdict::kSure;
  if (!witness.at_belief.has_value() ||
      witness.at_belief->judged < options.min_judged_beams) {
    return judgement;
  }
  const double worse =
      localization::FitScore(*witness.at_belief) - localization::FitScore(fit);
  if (worse <= kMaxWorseThanBelief) return judgement;
  judgement.verdict = worse > kRefusedWorseThanBelief ? FixVerdict::kAgainstScan
                                                      : FixVerdict::kWeak;
  absl::StrAppend(&judgement.why, "; where it thought it was fits better, ",
                  absl::StrFormat("%.2f and %.2f", witness.at_belief->explained,
                                  witness.at_belief->contradicted));
  return judgement;
}

// Of a fix that stands in obstacles of the map that are seen through: they are
// not there if the scan fits as well as at a sure place. Not more than weak.
FixJudgement JudgeAmongGhosts(FixJudgement judgement,
                              const ScanWitness& witness,
                              const FixGateOptions& options) {
  if (IsRefused(judgement.verdict)) return judgement;
  const bool fits = witness.at_fix.has_value() &&
                    witness.at_fix->judged >= options.min_judged_beams &&
                    witness.at_fix->explained >= options.sure_explained;
  judgement.verdict = fits ? FixVerdict::kWeak : FixVerdict::kNotOnGround;
  absl::StrAppend(&judgement.why,
                  "; the map has obstacles there, which the scan sees through",
                  fits ? "" : ", but fits too badly to say so");
  return judgement;
}

}  // namespace

absl::Status FixGateOptions::Validate() const {
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: min_confidence", min_confidence, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("gate: sure_confidence", sure_confidence,
                                      min_confidence, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: max_tilt_rad", max_tilt_rad, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: max_height_error_m", max_height_error_m, 0, 2));
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: min_clearance_m", min_clearance_m, 0, 2));
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: min_explained", min_explained, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: max_contradicted", max_contradicted, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("gate: sure_explained", sure_explained,
                                      min_explained, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("gate: sure_contradicted",
                                      sure_contradicted, 0, max_contradicted));
  TL_RETURN_IF_ERROR(
      base::CheckRange("gate: min_judged_beams", min_judged_beams, 0, 10000));
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

FixJudgement JudgeFix(const core::RelocalizationAnswer& answer,
                      const FixWitnesses& judging_particles,
                      const FixGateOptions& options) {
  if (auto refusal = RefusalByAnswer(answer, options)) return *refusal;
  if (judging_particles.tilt_error_rad.has_value()) {
    if (auto refusal =
            RefusalByGravity(*judging_particles.tilt_error_rad, options)) {
      return *refusal;
    }
  }
  if (judging_particles.ground.has_value()) {
    if (auto refusal = RefusalByMap(*judging_particles.ground, options)) {
      return *refusal;
    }
  }
  if (!judging_particles.scan.has_value()) {
    return {.verdict = FixVerdict::kWeak, .why = "no scan was compared"};
  }
  const FixJudgement judgement =
      JudgeByScan(answer, *judging_particles.scan, options);
  if (!judging_particles.ground.has_value() ||
      !judging_particles.ground->is_seen_through) {
    return judgement;
  }
  return JudgeAmongGhosts(judgement, *judging_particles.scan, options);
}

double TiltError_rad(const geometry::Rotation3& map_from_base,
                     const geometry::Rotation3& level_from_base) {
  const geometry::Vec3 up_of_fix =
      map_from_base.Inverse() * geometry::Vec3{0, 0, 1};
  const geometry::Vec3 up = level_from_base.Inverse() * geometry::Vec3{0, 0, 1};
  return std::acos(std::clamp(geometry::Dot(up_of_fix, up), -1.0, 1.0));
}

bool IsServerSure(const core::RelocalizationAnswer& answer,
                  const FixGateOptions& options) {
  return answer.confidence >=
         std::max(options.sure_confidence, answer.confidence_threshold);
}

double LogOddsOf(double confidence) {
  const double p = std::clamp(confidence, 0.01, 0.99);
  return std::log(p / (1 - p));
}

localization::PoseCovariance2 FixCovariance(
    const geometry::PoseCovariance& covariance) {
  const auto variance = [&covariance](size_t i, double min, double max) {
    return std::clamp(covariance[i], min * min, max * max);
  };
  return {variance(0, kMinFixStd_m, kMaxFixStd_m),     0, 0, 0,
          variance(7, kMinFixStd_m, kMaxFixStd_m),     0, 0, 0,
          variance(35, kMinFixStd_rad, kMaxFixStd_rad)};
}

std::string FixText(const GatedFix& fix) {
  return absl::StrCat(FixVerdictName(fix.verdict), fix.why.empty() ? "" : ": ",
                      fix.why);
}

bool FixesAgree(const GatedFix& first, const GatedFix& second,
                const FixGateOptions& options) {
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
  const double sigma_m = std::max(0.0, std::max(deviation(0), deviation(4)) -
                                           std::sqrt(2.0) * kMinFixStd_m);
  const double sigma_rad =
      std::max(0.0, deviation(8) - std::sqrt(2.0) * kMinFixStd_rad);
  return off_m <= options.pair_m + 2 * sigma_m &&
         off_rad <= options.pair_rad + 2 * sigma_rad &&
         std::abs(first.pose.place.height_m - second.pose.place.height_m) <
             kSamePlace_m + options.pair_m;
}

GatedFix CombinedFix(const GatedFix& earlier, GatedFix later) {
  const double turned_rad =
      geometry::NormalizedAngle_rad(later.motion.odom_from_base.yaw_rad -
                                    earlier.motion.odom_from_base.yaw_rad);
  later.log_odds = std::abs(turned_rad) >= kOtherView_rad
                       ? later.log_odds + earlier.log_odds
                       : std::max(later.log_odds, earlier.log_odds);
  later.is_server_sure |= earlier.is_server_sure;
  return later;
}

bool AreViewsSure(const GatedFix& combined) {
  return combined.is_server_sure || combined.log_odds >= kSureLogOdds;
}

}  // namespace treeline::behavior
