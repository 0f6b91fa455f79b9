#include "server/core/forest/confidence_model.h"

#include <algorithm>
#include <cmath>

namespace treeline::forest {
namespace {

// What stands for evidence that there is none of: between that of right poses
// and that of wrong ones.
constexpr double kUnknownCorrelation = 0.6;
constexpr double kUnknownAgreement = 0.4;
constexpr double kUnknownDepthAgreement = 0.8;
constexpr double kUnknownSteadiness = 0.6;

// Of few points little is known.
double DepthAgreement(const PoseEvidence& evidence) {
  constexpr double kFew = 10;
  return (evidence.measured * evidence.depth_agreement +
          kFew * kUnknownDepthAgreement) /
         (evidence.measured + kFew);
}

// 0 at 5 cm and more, 1 at 5 mm and less.
double Sharpness(double sigma_m) {
  if (!(sigma_m > 0)) return 0;
  return std::clamp(-std::log10(sigma_m / 0.05), 0.0, 1.0);
}

// What supports a pose is found elsewhere, too, if less than this share of it
// is distinct. In rooms nothing of which repeats it is 0.71 and more, with half
// of the picture cut away or covered (docs/research/growth.md).
constexpr double kSureDistinct = 0.7;
// Such a place has to look as learnt, in every part of the picture; if less
// than this is distinct, even that says nothing.
constexpr double kMinDistinct = 0.3;
// The odds' logarithm then, at most: rather wrong than right.
constexpr double kElsewhereLogit = -0.4;

}  // namespace

bool MayBeElsewhere(const PoseEvidence& evidence) {
  return evidence.matches > 0 &&
         (evidence.distinct < kMinDistinct ||
          (evidence.distinct < kSureDistinct && evidence.contradicted > 0));
}

const std::array<absl::string_view, ConfidenceModel::kFeatures>&
ConfidenceModel::FeatureNames() {
  static constexpr std::array<absl::string_view, kFeatures> kNames = {
      "constant", "inlier_ratio", "correlation", "agreement", "depth_agreement",
      "steady",   "overlap",      "is_matched",  "matches",   "sharpness"};
  return kNames;
}

ConfidenceModel::Features ConfidenceModel::FeaturesOf(
    const PoseEvidence& evidence) {
  const bool is_aligned = evidence.visible > 0;
  return {1,
          // The first few per cent decide.
          std::sqrt(std::max(0.0, evidence.inlier_ratio)),
          is_aligned ? evidence.correlation : kUnknownCorrelation,
          is_aligned ? evidence.agreement : kUnknownAgreement,
          DepthAgreement(evidence),
          // 1: alignment left the pose where it was.
          is_aligned ? 1 - std::min(1.0, evidence.moved_m / 0.1)
                     : kUnknownSteadiness,
          evidence.overlap, evidence.matches > 0 ? 1.0 : 0.0,
          // 0 to 100 of them: from 0 to 1; the first ones decide.
          std::min(1.0, std::log1p(evidence.matches) / std::log1p(100)),
          Sharpness(evidence.sigma_m)};
}

double ConfidenceModel::Probability(const PoseEvidence& evidence) const {
  const Features features = FeaturesOf(evidence);
  double logit = 0;
  for (size_t i = 0; i < kFeatures; ++i) logit += weights[i] * features[i];
  if (MayBeElsewhere(evidence)) logit = std::min(logit, kElsewhereLogit);
  return 1 / (1 + std::exp(-logit));
}

ConfidenceModel ConfidenceModel::Typical() {
  return {{-10.75, 4.35, 0, 5.82, 2.46, 2.85, 0, 0, 0, 3.94}, 0.5};
}

ConfidenceModel ConfidenceModel::WithoutKeyframes() {
  // A share of 10 % is even odds.
  return {{-9.5, 30, 0, 0, 0, 0, 0}, 0.5};
}

ConfidenceModel ConfidenceModel::OfSiftMatches() {
  // 12 are about even odds, whatever the share: 9 agree by chance, and 15 do
  // not (docs/research/structure-from-motion.md).
  return {{-26.5, 5, 0, 0, 0, 0, 0, 0, 45, 0}, 0.5};
}

}  // namespace treeline::forest
