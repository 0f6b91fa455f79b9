// Verification where there are no keyframes: how many of the matches support
// the pose, and how well they determine it.
#ifndef SERVER_CORE_LOCALIZER_SUPPORT_VERIFIER_H_
#define SERVER_CORE_LOCALIZER_SUPPORT_VERIFIER_H_

#include "server/core/forest/model_info.h"
#include "server/core/localizer/pose_verifier.h"

namespace treeline::localizer {

class SupportVerifier final : public PoseVerifier {
 public:
  // Takes the confidence and the viewing distance, which is the scale of
  // errors.
  explicit SupportVerifier(const forest::ModelInfo& info);

  // The candidate's pose as it is.
  Verdict Verify(Query& query, const Candidate& candidate) const override;
  double MinConfidence(const LocalizeOptions& options) const override {
    return options.min_confidence.value_or(confidence_.threshold);
  }
  double MaxPositionSigma() const override;

 private:
  const forest::ConfidenceModel confidence_;
  const double viewing_distance_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_SUPPORT_VERIFIER_H_
