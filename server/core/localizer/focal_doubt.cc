#include "server/core/localizer/focal_doubt.h"

#include <algorithm>
#include <cmath>

#include "server/core/localizer/parameters.h"

namespace treeline::localizer {
namespace {

double LogError(const pose::FocalEstimate& focal) {
  return std::abs(std::log(focal.scale));
}

// Of two that know nothing of each other.
pose::FocalEstimate Fused(const pose::FocalEstimate& a,
                          const pose::FocalEstimate& b) {
  const double of_a = 1 / (a.sigma * a.sigma);
  const double of_b = 1 / (b.sigma * b.sigma);
  return {
      .scale = std::exp((of_a * std::log(a.scale) + of_b * std::log(b.scale)) /
                        (of_a + of_b)),
      .sigma = 1 / std::sqrt(of_a + of_b)};
}

}  // namespace

double ErrorSigmas(const pose::FocalEstimate& focal) {
  return LogError(focal) / focal.sigma;
}

bool DoubtsFocal(const pose::FocalEstimate& points) {
  return LogError(points) >= kMinFocalError &&
         ErrorSigmas(points) >= kDoubtfulPointFocalSigmas;
}

bool IsGuessConfirmed(const FocalEvidence& evidence, double max_sigma) {
  return evidence.features && evidence.features->sigma <= max_sigma &&
         !FocalDoubt(/*may_be_guessed=*/true, /*sigma_scale=*/1)
              .Other({.features = evidence.features});
}

FocalDoubt::FocalDoubt(bool may_be_guessed, double sigma_scale)
    : may_be_guessed_(may_be_guessed), sigma_scale_(sigma_scale) {}

std::optional<OtherFocal> FocalDoubt::Other(
    const FocalEvidence& evidence) const {
  if (!evidence.features) return std::nullopt;
  if (!evidence.points) {
    return Other(
        *evidence.features, kMinFocalSigmas,
        std::max<double>(kSureFocalSigmas, kMinFocalSigmas * sigma_scale_));
  }
  pose::FocalEstimate features = *evidence.features;
  features.sigma *= sigma_scale_;
  return Other(Fused(features, *evidence.points), kMinFusedFocalSigmas,
               kClearFocalSigmas);
}

std::optional<OtherFocal> FocalDoubt::Other(const pose::FocalEstimate& focal,
                                            double min_known_sigmas,
                                            double sure_known_sigmas) const {
  const double sigmas = ErrorSigmas(focal);
  if (LogError(focal) < kMinFocalError ||
      sigmas <
          (may_be_guessed_ ? kMinGuessedFocalSigmas.value : min_known_sigmas)) {
    return std::nullopt;
  }
  if (sigmas >=
      (may_be_guessed_ ? kClearFocalSigmas.value : sure_known_sigmas)) {
    return OtherFocal{focal.scale, kClearFocalOdds};
  }
  return OtherFocal{focal.scale, may_be_guessed_ ? 1 : kUnsureFocalOdds.value};
}

}  // namespace treeline::localizer
