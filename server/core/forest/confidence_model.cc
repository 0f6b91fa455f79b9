#include "server/core/forest/confidence_model.h"

#include <algorithm>
#include <cmath>

namespace treeline {

const std::array<absl::string_view, ConfidenceModel::kFeatures>&
ConfidenceModel::FeatureNames() {
  static constexpr std::array<absl::string_view, kFeatures> kNames = {
      "constant", "inlier_ratio",    "correlation", "agreement",
      "visible",  "depth_agreement", "steady"};
  return kNames;
}

ConfidenceModel::Features ConfidenceModel::FeaturesOf(
    const PoseEvidence& evidence) {
  return {1,
          // The first few per cent decide.
          std::sqrt(std::max(0.0, evidence.inlier_ratio)), evidence.correlation,
          evidence.agreement, std::min(1.0, evidence.visible / 1000.0),
          evidence.depth_agreement,
          // 1: alignment left the pose where it was.
          1 - std::min(1.0, evidence.moved_m / 0.1)};
}

double ConfidenceModel::Probability(const PoseEvidence& evidence) const {
  const Features features = FeaturesOf(evidence);
  double logit = 0;
  for (size_t i = 0; i < kFeatures; ++i) logit += weights[i] * features[i];
  return 1 / (1 + std::exp(-logit));
}

ConfidenceModel ConfidenceModel::Typical() {
  return {{-12, 5, 10, 3, 1, 2, 1}, 0.5};
}

ConfidenceModel ConfidenceModel::WithoutKeyframes() {
  // A share of 10 % is even odds.
  return {{-9.5, 30, 0, 0, 0, 0, 0}, 0.5};
}

}  // namespace treeline
