// The thesis's chapter 3 (Algorithm 1): a forest on colour gives an initial
// pose, and SIFT features of the keyframes near it an exact one.
#ifndef SERVER_CORE_LOCALIZER_HYBRID_LOCALIZER_H_
#define SERVER_CORE_LOCALIZER_HYBRID_LOCALIZER_H_

#include <memory>
#include <span>

#include "common/camera/camera.h"
#include "server/core/forest/model_file.h"
#include "server/core/keyframes/keyframe_features.h"
#include "server/core/localizer/forest_query.h"
#include "server/core/localizer/localizer.h"
#include "server/core/localizer/pose_verifier.h"
#include "server/core/localizer/query_options.h"

namespace treeline::localizer {

// Answers with the colour camera's pose. Depth in a frame is ignored. Where the
// features of the keyframes near the forest's pose support none, those of the
// keyframes most like the frame are tried, and then it answers as method rgb
// does.
class HybridLocalizer final : public Localizer {
 public:
  HybridLocalizer(std::unique_ptr<const forest::ModelFile> model,
                  PoseVerifier verifier, const QueryOptions& options);

  absl::StatusOr<PoseEstimate> Localize(
      const image::Frame& frame, const LocalizeOptions& options) const override;
  const forest::ModelInfo& info() const override { return model_->info(); }

 private:
  struct MatchedPose;
  MatchedPose SolveKeyframes(const features::SiftFeatures& features,
                             std::span<const size_t> keyframes,
                             const camera::Camera& camera,
                             const LocalizeOptions& options) const;

  const std::unique_ptr<const forest::ModelFile> model_;
  const PoseVerifier verifier_;
  const QueryOptions options_;
  mutable Pool<ForestScratch> scratch_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_HYBRID_LOCALIZER_H_
