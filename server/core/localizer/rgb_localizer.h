// The thesis's chapter 4 without depth in queries ("BTBRF, RGB at test"):
// sample pixels, ask the backtracking forest for their scene coordinates, and
// solve Perspective-n-Point.
#ifndef SERVER_CORE_LOCALIZER_RGB_LOCALIZER_H_
#define SERVER_CORE_LOCALIZER_RGB_LOCALIZER_H_

#include <memory>

#include "server/core/forest/model_file.h"
#include "server/core/localizer/forest_query.h"
#include "server/core/localizer/localizer.h"
#include "server/core/localizer/pose_verifier.h"
#include "server/core/localizer/query_options.h"

namespace treeline::localizer {

// Answers with the colour camera's pose. Depth in a frame is ignored.
class RgbLocalizer final : public Localizer {
 public:
  RgbLocalizer(std::unique_ptr<const forest::ModelFile> model,
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

#endif  // SERVER_CORE_LOCALIZER_RGB_LOCALIZER_H_
