// Verification against the model's keyframes: a pose is made exact, and the
// frame must look as they say.
#ifndef SERVER_CORE_LOCALIZER_KEYFRAME_VERIFIER_H_
#define SERVER_CORE_LOCALIZER_KEYFRAME_VERIFIER_H_

#include <memory>

#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "server/core/forest/model_file.h"
#include "server/core/keyframes/keyframe_map.h"
#include "server/core/localizer/parameters.h"
#include "server/core/localizer/pose_verifier.h"
#include "server/core/pose/pose_fusion.h"

namespace treeline::localizer {

// What becomes of a candidate whose pose alignment with keyframes made exact.
enum class AlignmentUse {
  kReplaces,  // the aligned pose is the answer
  kFuses      // both are estimates of it, as sure as their covariances say
};

class KeyframeVerifier final : public PoseVerifier {
 public:
  // DATA_LOSS for corrupt keyframes.
  static absl::StatusOr<std::unique_ptr<const KeyframeVerifier>> Create(
      const forest::ModelFile& model, AlignmentUse use);

  // Aligns the pose with the keyframes around, where there are any, by colour
  // and, if the query has it, by depth.
  Verdict Verify(Query& query, const Candidate& candidate) const override;
  double MinConfidence(const LocalizeOptions& options) const override {
    return options.min_confidence.value_or(confidence_.threshold);
  }
  double MaxPositionSigma() const override { return kMaxPositionSigma_m; }
  std::optional<keyframes::DepthScale> MeasureDepth(
      Query& query, const geometry::Rigid3& world_from_camera) const override;

  const keyframes::KeyframeMap& keyframes() const { return keyframes_; }

 private:
  // In even light, or in some that differs over the picture.
  Verdict Judge(Query& query, const Candidate& candidate,
                bool evens_light) const;
  pose::PoseWithCovariance Answer(
      const pose::RefinedPose& candidate,
      const pose::PoseWithCovariance& aligned) const;

  AlignmentUse use_ = AlignmentUse::kReplaces;
  camera::Camera learnt_;
  keyframes::KeyframeMap keyframes_;
  forest::ConfidenceModel confidence_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_KEYFRAME_VERIFIER_H_
