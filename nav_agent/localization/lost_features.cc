#include "nav_agent/localization/lost_features.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/base/check_range.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "nav_agent/localization/parameters.h"

namespace treeline::localization {
namespace {

// What one saw in each direction: from the nearest to the farthest.
class Panorama {
 public:
  Panorama(const std::vector<geometry::Vec2>& ends_before,
           const geometry::Rigid2& now_from_before) {
    nearest_.fill(std::numeric_limits<double>::infinity());
    farthest_.fill(0);
    for (const geometry::Vec2 end : ends_before) {
      const geometry::Vec2 at = now_from_before * end;
      const double range_m = geometry::Norm(at);
      const size_t sector = SectorOf(at);
      nearest_[sector] = std::min(nearest_[sector], range_m);
      farthest_[sector] = std::max(farthest_[sector], range_m);
    }
  }

  // Whether something was there, or was not; nullopt: nobody looked.
  std::optional<bool> WasThere(geometry::Vec2 end) const {
    const size_t middle = SectorOf(end);
    double nearest_m = std::numeric_limits<double>::infinity();
    double farthest_m = 0;
    int seen = 0;
    for (size_t k = 0; k < 3; ++k) {
      const size_t sector = (middle + kSectors + k - 1) % kSectors;
      if (farthest_[sector] <= 0) continue;
      ++seen;
      nearest_m = std::min(nearest_m, nearest_[sector]);
      farthest_m = std::max(farthest_m, farthest_[sector]);
    }
    if (seen < 2) return std::nullopt;
    const double range_m = geometry::Norm(end);
    const double tolerance_m = kSameRange_m + kSameRangeShare * range_m;
    return range_m > nearest_m - tolerance_m &&
           range_m < farthest_m + tolerance_m;
  }

 private:
  static size_t SectorOf(geometry::Vec2 at) {
    const double turn =
        (std::atan2(at.y, at.x) / (2 * std::numbers::pi) + 0.5) *
        static_cast<double>(kSectors);
    return static_cast<size_t>(turn) % kSectors;
  }

  std::array<double, kSectors> nearest_{};
  std::array<double, kSectors> farthest_{};
};

std::vector<std::optional<bool>> ThereBefore(
    const std::vector<geometry::Vec2>& before,
    const geometry::Rigid2& now_from_before,
    const std::vector<CheckedBeam>& beams) {
  const Panorama panorama(before, now_from_before);
  std::vector<std::optional<bool>> there;
  there.reserve(beams.size());
  for (const CheckedBeam& beam : beams) {
    there.push_back(panorama.WasThere(beam.end_in_base));
  }
  return there;
}

double Clamp01(double value) {
  // What is not a number is as bad as can be.
  return std::isnan(value) ? 1 : std::clamp(value, 0.0, 1.0);
}

}  // namespace

absl::Status LostFeatureOptions::Validate() const {
  TL_RETURN_IF_ERROR(base::CheckRange("lost: prior_share", prior_share, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: lifted_rad", lifted_rad, 0.05, 1.5));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lost: lifted_radps", lifted_radps, 0.1, 20));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: slide_m", slide_m, 0.01, 10));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: spread_m", spread_m, 0.01, 10));
  TL_RETURN_IF_ERROR(base::CheckRange("lost: history_s", history_s, 1, 3600));
  return base::CheckRange("lost: usual_explained", usual_explained, 0, 1);
}

void LostFeatureMaker::Reset() {
  past_.clear();
  usual_explained_ = options_.usual_explained;
}

const LostFeatureMaker::Past* LostFeatureMaker::Before(base::MonotonicTime now,
                                                       double age_s) const {
  const Past* found = nullptr;
  for (const Past& past : past_) {
    const double its_age_s = base::SecondsBetween(past.stamp, now);
    if (its_age_s < kYoungestScan_s) break;
    // The oldest there is, while none is old enough.
    if (found == nullptr || its_age_s >= age_s) found = &past;
  }
  return found;
}

void LostFeatureMaker::WatchTilt(const LostEvidence& evidence,
                                 LostFeatures& features) const {
  features.is_on_slope = std::max(std::abs(evidence.pitch_rad),
                                  std::abs(evidence.roll_rad)) > kOnSlope_rad;
  features.is_lifted =
      std::hypot(evidence.pitch_rad, evidence.roll_rad) > options_.lifted_rad;
  const Past* before = Before(evidence.stamp, kYoungestScan_s);
  if (before == nullptr) return;
  const double interval_s = base::SecondsBetween(before->stamp, evidence.stamp);
  const double tilted_rad = std::hypot(evidence.pitch_rad - before->pitch_rad,
                                       evidence.roll_rad - before->roll_rad);
  features.is_lifted |= tilted_rad > options_.lifted_radps * interval_s;
}

void LostFeatureMaker::Count(const std::vector<CheckedBeam>& beams,
                             const std::vector<bool>& was_there, double doubt,
                             double interval_s, LostFeatures& features) {
  double explained = 0;
  double residual = 0;
  double passing = 0;
  double fixed = 0;
  double moving = 0;
  for (size_t i = 0; i < beams.size(); ++i) {
    switch (beams[i].fit) {
      case BeamFit::kExplained:
        ++explained;
        residual += std::min(1.0, beams[i].distance_m / kMaxResidual_m);
        break;
      case BeamFit::kLong:
        ++passing;
        break;
      case BeamFit::kShort:
        ++(was_there[i] ? fixed : moving);
        break;
      case BeamFit::kNotJudged:
        break;
    }
  }
  // So many beams that say nothing are added: a handful proves nothing.
  const double nothing =
      1 + options_.prior_share * static_cast<double>(beams.size());
  const double judged = explained + passing + fixed + moving + 1e-9;
  const double standing = explained + passing + fixed;
  features.long_share = passing / judged;
  features.changed_share = fixed / judged;
  features.moving_share = moving / judged;
  features.explained_share = explained / judged;
  auto& values = features.values;
  values[kLongShare] = passing / (explained + passing + nothing);
  values[kResidual] =
      (residual + kUsualResidual * nothing) / (explained + nothing);
  values[kChangedShare] = fixed / (standing + nothing);
  const double share =
      (explained + usual_explained_ * nothing) / (standing + nothing);
  values[kDeficit] = Clamp01(usual_explained_ - share);
  // Learned from while nothing is wrong, and slowly.
  const double gain =
      (1 - Clamp01(doubt)) * std::min(1.0, interval_s / options_.history_s);
  usual_explained_ += gain * (share - usual_explained_);
}

LostFeatures LostFeatureMaker::Observe(const LostEvidence& evidence,
                                       const std::vector<CheckedBeam>& beams,
                                       double doubt) {
  LostFeatures features;
  WatchTilt(evidence, features);
  const PlanarEstimate& estimate = evidence.estimate;
  std::vector<bool> was_there(beams.size(), true);
  double interval_s = 0;
  if (!past_.empty()) {
    interval_s = base::SecondsBetween(past_.back().stamp, evidence.stamp);
  }
  if (const Past* past = Before(evidence.stamp, kJumpAge_s)) {
    const geometry::Rigid2 now_from_before =
        evidence.odom_from_base.Inverse() * past->odom_from_base;
    const std::vector<std::optional<bool>> there =
        ThereBefore(past->ends_in_base, now_from_before, beams);
    double seen = 1 + options_.prior_share * static_cast<double>(beams.size());
    double new_ones = 0;
    for (size_t i = 0; i < beams.size(); ++i) {
      // People come and go before the map; they are no other place.
      const bool counts =
          beams[i].fit == BeamFit::kExplained || beams[i].fit == BeamFit::kLong;
      if (!counts || !there[i].has_value()) continue;
      ++seen;
      new_ones += beams[i].fit == BeamFit::kLong && !*there[i] ? 1 : 0;
    }
    features.jump = new_ones / seen;
  }
  if (const Past* past = Before(evidence.stamp, kIdentityAge_s)) {
    const geometry::Rigid2 by_wheels =
        past->odom_from_base.Inverse() * evidence.odom_from_base;
    const geometry::Rigid2 by_estimate =
        past->map_from_base.Inverse() * estimate.map_from_base;
    const double slid_m =
        geometry::Norm(by_wheels.translation - by_estimate.translation) +
        std::abs(geometry::NormalizedAngle_rad(by_wheels.yaw_rad -
                                               by_estimate.yaw_rad));
    features.values[kSlide] = Clamp01(slid_m / options_.slide_m);
    // In the map: what stands keeps its place there.
    const std::vector<std::optional<bool>> there =
        ThereBefore(past->ends_in_base, by_estimate.Inverse(), beams);
    for (size_t i = 0; i < there.size(); ++i) {
      was_there[i] = there[i].value_or(true);
    }
  }
  features.values[kSpread] = Clamp01(
      std::sqrt(std::max(0.0, estimate.covariance[0] + estimate.covariance[4]) /
                2) /
      options_.spread_m);
  features.values[kElsewhere] = Clamp01(1 - estimate.share);
  Count(beams, was_there, doubt, interval_s, features);

  Past now{.stamp = evidence.stamp,
           .odom_from_base = evidence.odom_from_base,
           .map_from_base = estimate.map_from_base,
           .pitch_rad = evidence.pitch_rad,
           .roll_rad = evidence.roll_rad,
           .ends_in_base = {}};
  now.ends_in_base.reserve(beams.size());
  for (const CheckedBeam& beam : beams) {
    now.ends_in_base.push_back(beam.end_in_base);
  }
  past_.push_back(std::move(now));
  while (base::SecondsBetween(past_.front().stamp, evidence.stamp) >
         kScanMemory_s) {
    past_.pop_front();
  }
  return features;
}

}  // namespace treeline::localization
