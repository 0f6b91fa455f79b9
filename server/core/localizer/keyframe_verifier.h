// Verification against the model's keyframes: a pose is made exact, and the
// frame must look as they say.
#ifndef SERVER_CORE_LOCALIZER_KEYFRAME_VERIFIER_H_
#define SERVER_CORE_LOCALIZER_KEYFRAME_VERIFIER_H_

#include <memory>

#include "absl/status/statusor.h"
#include "server/core/forest/model_file.h"
#include "server/core/keyframes/keyframe_map.h"
#include "server/core/localizer/pose_verifier.h"

namespace treeline::localizer {

class KeyframeVerifier final : public PoseVerifier {
 public:
  // DATA_LOSS for corrupt keyframes.
  static absl::StatusOr<std::unique_ptr<const KeyframeVerifier>> Create(
      const forest::ModelFile& model);

  // Aligns the pose with the keyframes around, where there are any, by colour
  // and, if the query has it, by depth.
  Verdict Verify(Query& query, const Candidate& candidate) const override;

  const keyframes::KeyframeMap& keyframes() const { return keyframes_; }

 private:
  keyframes::KeyframeMap keyframes_;
  forest::ConfidenceModel confidence_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_KEYFRAME_VERIFIER_H_
