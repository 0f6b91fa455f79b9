#include "server/core/localizer/support_verifier.h"

#include "server/core/localizer/parameters.h"

namespace treeline::localizer {

SupportVerifier::SupportVerifier(const forest::ModelInfo& info)
    : confidence_(
          info.confidence.value_or(forest::ConfidenceModel::OfSiftMatches())),
      viewing_distance_(info.viewing_distance) {}

double SupportVerifier::MaxPositionSigma() const {
  return kMaxRelativePositionSigma * viewing_distance_;
}

Verdict SupportVerifier::Verify(Query& query,
                                const Candidate& candidate) const {
  const pose::RefinedPose& pose = *candidate.pose;
  Verdict verdict;
  verdict.world_from_camera = pose.world_from_camera;
  verdict.covariance = pose.covariance;
  // A share of few matches means little.
  verdict.evidence.inlier_ratio =
      static_cast<double>(pose.inliers) / (candidate.samples + kFewMatches);
  verdict.evidence.matches = candidate.places;
  verdict.confidence = confidence_.Probability(verdict.evidence);
  verdict.reason = ReasonAgainst(
      {.has_enough_inliers = candidate.places >= kMinSiftInliers,
       .is_determined = PositionSigma_m(pose.covariance) <= MaxPositionSigma(),
       .is_confident = verdict.confidence >= MinConfidence(query.options())});
  return verdict;
}

}  // namespace treeline::localizer
