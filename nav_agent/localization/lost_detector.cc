#include "nav_agent/localization/lost_detector.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/check_range.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "nav_agent/localization/parameters.h"

namespace treeline::localization {
namespace {

double Logistic(double x) { return 1 / (1 + std::exp(-x)); }

bool IsFinite(const geometry::Rigid2& pose) {
  return std::isfinite(pose.translation.x) &&
         std::isfinite(pose.translation.y) && std::isfinite(pose.yaw_rad);
}

bool IsFinite(const LostEvidence& evidence) {
  const PlanarEstimate& estimate = evidence.estimate;
  return IsFinite(estimate.map_from_base) &&
         IsFinite(evidence.odom_from_base) &&
         std::isfinite(estimate.covariance[0]) &&
         std::isfinite(estimate.covariance[4]) &&
         std::isfinite(estimate.share) && std::isfinite(evidence.pitch_rad) &&
         std::isfinite(evidence.roll_rad);
}

}  // namespace

double LostModel::LogRatio(
    const std::array<double, kLostFeatures>& values) const {
  double sum = bias;
  for (size_t i = 0; i < kLostFeatures; ++i) sum += weights[i] * values[i];
  return sum;
}

LostModel LostModel::Trained() {
  // treeline-agent suite lost-fit, worlds seed:1 to seed:12; see the page.
  LostModel model;
  model.bias = -5.429;
  model.weights[kLongShare] = 9.007;
  model.weights[kResidual] = 12.015;
  model.weights[kChangedShare] = 0;
  model.weights[kDeficit] = 8.993;
  model.weights[kSlide] = 2.844;
  model.weights[kSpread] = 6.708;
  model.weights[kElsewhere] = 0;
  return model;
}

absl::Status LostFilterOptions::Validate() const {
  for (const double weight : model.weights) {
    TL_RETURN_IF_ERROR(base::CheckRange("lost: a weight", weight, 0, 1000));
  }
  TL_RETURN_IF_ERROR(base::CheckRange("lost: bias", model.bias, -1000, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: independent_s", independent_s, 0.01, 60));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: max_log_odds_for", max_log_odds_for, 0.1, 100));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: max_log_odds_against",
                                      max_log_odds_against, 0.1, 100));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: slope_part", slope_part, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: loss_hz", loss_hz, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: jump_from", jump_from, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: jump_to", jump_to, jump_from, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: jump_chance", jump_chance, 0, 0.999));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: lifted_chance", lifted_chance, 0, 0.999));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: max_log_odds_lost", max_log_odds_lost, 0.1, 100));
  return base::CheckRange("lost: max_log_odds_not_lost", max_log_odds_not_lost,
                          0.1, 100);
}

LostFilter::LostFilter(const LostFilterOptions& options)
    : options_(options), log_odds_(-options.max_log_odds_not_lost) {
  Reset();
}

void LostFilter::Reset() {
  // Put somewhere, it is most likely there; a scan or two say whether.
  log_odds_ = -options_.max_log_odds_not_lost / 2;
  log_ratio_ = 0;
}

double LostFilter::Probability() const { return Logistic(log_odds_); }

double LostFilter::Observe(const LostFeatures& features, double interval_s) {
  // What may have happened since the last scan.
  double chance = std::clamp(options_.loss_hz * interval_s, 0.0, 0.5);
  const double width = std::max(1e-6, options_.jump_to - options_.jump_from);
  const double jumped =
      std::clamp((features.jump - options_.jump_from) / width, 0.0, 1.0);
  chance = std::max(chance, jumped * options_.jump_chance);
  if (features.is_lifted) chance = std::max(chance, options_.lifted_chance);
  const double lost = Logistic(log_odds_);
  const double now_lost = lost + (1 - lost) * chance;
  log_odds_ = std::log(now_lost / (1 - now_lost));
  // What the scan says.
  log_ratio_ =
      std::clamp(options_.model.LogRatio(features.values),
                 -options_.max_log_odds_against, options_.max_log_odds_for);
  if (features.is_on_slope) log_ratio_ *= options_.slope_part;
  const double share =
      std::clamp(interval_s / options_.independent_s, 0.0, 1.0);
  log_odds_ =
      std::clamp(log_odds_ + share * log_ratio_,
                 -options_.max_log_odds_not_lost, options_.max_log_odds_lost);
  return Probability();
}

const char* LostStateName(LostState state) {
  switch (state) {
    case LostState::kLocalized:
      return "localized";
    case LostState::kMapChangedHere:
      return "map changed here";
    case LostState::kPeopleNearby:
      return "people nearby";
    case LostState::kLost:
      return "lost";
  }
  return "?";
}

const char* LostReasonName(LostReason reason) {
  switch (reason) {
    case LostReason::kNone:
      return "none";
    case LostReason::kPassesThroughWalls:
      return "beams pass through walls";
    case LostReason::kDoesNotFit:
      return "scans do not fit";
    case LostReason::kJumped:
      return "another place all at once";
    case LostReason::kLifted:
      return "lifted";
    case LostReason::kNotSure:
      return "not sure of one place";
  }
  return "?";
}

absl::Status LostDetectorOptions::Validate() const {
  TL_RETURN_IF_ERROR(scan.Validate());
  TL_RETURN_IF_ERROR(features.Validate());
  TL_RETURN_IF_ERROR(filter.Validate());
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: declare_at", declare_at, 1e-6, 0.999999));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: withdraw_at", withdraw_at, 0, declare_at));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: notable_share", notable_share, 0, 1));
  return base::CheckRange("lost: min_interval_s", min_interval_s, 0, 10);
}

absl::StatusOr<LostDetector> LostDetector::Create(
    const LaserMap& map, const core::RangeSensorInfo& laser,
    const geometry::Rigid3& base_from_laser,
    const LostDetectorOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (!IsFinite(base_from_laser) || laser.beams < 1) {
    return absl::InvalidArgumentError(
        "lost: a laser needs beams and a finite pose");
  }
  TL_ASSIGN_OR_RETURN(ScanChecker checker,
                      ScanChecker::Create(map, options.scan));
  return LostDetector(std::move(checker), laser, base_from_laser, options);
}

LostDetector::LostDetector(ScanChecker checker,
                           const core::RangeSensorInfo& laser,
                           const geometry::Rigid3& base_from_laser,
                           const LostDetectorOptions& options)
    : options_(options),
      checker_(std::move(checker)),
      laser_(laser),
      base_from_laser_(base_from_laser),
      maker_(options.features),
      filter_(options.filter) {}

void LostDetector::Reset() {
  maker_.Reset();
  filter_.Reset();
  last_.reset();
  jumped_.reset();
  lifted_.reset();
  verdict_ = {};
}

absl::Status LostDetector::SetMap(const LaserMap& map) {
  TL_ASSIGN_OR_RETURN(checker_, ScanChecker::Create(map, options_.scan));
  return absl::OkStatus();
}

void LostDetector::ExplainByThings(const PlanarEstimate& estimate,
                                   std::vector<CheckedBeam>& beams) const {
  if (things_ == nullptr) return;
  for (CheckedBeam& beam : beams) {
    if (beam.fit != BeamFit::kShort) continue;
    const geometry::Vec2 end = estimate.map_from_base * beam.end_in_base;
    if (!things_->IsNear(estimate.place.level, end)) continue;
    beam.fit = BeamFit::kExplained;
    beam.distance_m = std::min(beam.distance_m, KnownThings::kCell_m);
  }
}

LostReason LostDetector::ReasonFor(const LostFeatures& features) const {
  if (lifted_.has_value() &&
      base::SecondsBetween(*lifted_, *last_) < kLostReasonMemory_s) {
    return LostReason::kLifted;
  }
  if (jumped_.has_value() &&
      base::SecondsBetween(*jumped_, *last_) < kLostReasonMemory_s) {
    return LostReason::kJumped;
  }
  const LostModel& model = options_.filter.model;
  const auto part = [&](LostFeature feature) {
    return model.weights[feature] * features.values[feature];
  };
  const double unsure = part(kSpread) + part(kElsewhere);
  const double misfit = part(kLongShare) + part(kResidual) +
                        part(kChangedShare) + part(kDeficit) + part(kSlide);
  if (unsure >= misfit) return LostReason::kNotSure;
  return features.values[kLongShare] >= options_.notable_share
             ? LostReason::kPassesThroughWalls
             : LostReason::kDoesNotFit;
}

LostState LostDetector::StateFor(const LostFeatures& features) const {
  const double from = verdict_.state == LostState::kLost ? options_.withdraw_at
                                                         : options_.declare_at;
  if (filter_.Probability() >= from) return LostState::kLost;
  const double changed = features.changed_share + features.long_share;
  if (std::max(changed, features.moving_share) < options_.notable_share) {
    return LostState::kLocalized;
  }
  return changed > features.moving_share ? LostState::kMapChangedHere
                                         : LostState::kPeopleNearby;
}

absl::StatusOr<LostVerdict> LostDetector::Observe(const LostEvidence& evidence,
                                                  const core::LaserScan& scan) {
  if (!IsFinite(evidence)) {
    return absl::InvalidArgumentError("lost: evidence that is not finite");
  }
  double interval_s = 0;
  if (last_.has_value()) {
    interval_s = base::SecondsBetween(*last_, evidence.stamp);
    if (interval_s < 0) {
      return absl::InvalidArgumentError("lost: the clock went back");
    }
    if (interval_s < options_.min_interval_s) return verdict_;
  }
  TL_ASSIGN_OR_RETURN(
      std::vector<CheckedBeam> beams,
      checker_.Check({.map_from_base = evidence.estimate.map_from_base,
                      .pitch_rad = evidence.pitch_rad,
                      .roll_rad = evidence.roll_rad},
                     laser_, base_from_laser_, scan));
  ExplainByThings(evidence.estimate, beams);
  last_ = evidence.stamp;
  const LostFeatures features =
      maker_.Observe(evidence, beams, filter_.Probability());
  if (features.is_lifted) lifted_ = evidence.stamp;
  if (features.jump > options_.filter.jump_from) jumped_ = evidence.stamp;
  verdict_.probability = filter_.Observe(features, interval_s);
  verdict_.features = features;
  verdict_.state = StateFor(features);
  verdict_.reason = verdict_.state == LostState::kLost ? ReasonFor(features)
                                                       : LostReason::kNone;
  return verdict_;
}

}  // namespace treeline::localization
