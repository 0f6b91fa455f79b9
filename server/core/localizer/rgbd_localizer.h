// The thesis's chapter 4 on RGB-D frames: sample pixels, ask the backtracking
// forest for their scene coordinates, fit a pose.
#ifndef SERVER_CORE_LOCALIZER_RGBD_LOCALIZER_H_
#define SERVER_CORE_LOCALIZER_RGBD_LOCALIZER_H_

#include <memory>

#include "server/core/forest/model_file.h"
#include "server/core/localizer/forest_query.h"
#include "server/core/localizer/localizer.h"
#include "server/core/localizer/pose_verifier.h"
#include "server/core/localizer/query_options.h"

namespace treeline::localizer {

class RgbdLocalizer final : public Localizer {
 public:
  RgbdLocalizer(std::unique_ptr<const forest::ModelFile> model,
                PoseVerifier verifier, const QueryOptions& options);

  absl::StatusOr<PoseEstimate> Localize(
      const image::Frame& frame, const LocalizeOptions& options) const override;
  const forest::ModelInfo& info() const override { return model_->info(); }

 private:
  const std::unique_ptr<const forest::ModelFile> model_;
  const PoseVerifier verifier_;
  const QueryOptions options_;
  mutable Pool<ForestScratch> scratch_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_RGBD_LOCALIZER_H_
