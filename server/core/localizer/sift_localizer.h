// The thesis's chapter 4 outdoors: SIFT features, their places in the scene
// from a backtracking forest that was trained on a structure from motion, and
// Perspective-n-Point.
#ifndef SERVER_CORE_LOCALIZER_SIFT_LOCALIZER_H_
#define SERVER_CORE_LOCALIZER_SIFT_LOCALIZER_H_

#include <memory>

#include "absl/status/statusor.h"
#include "server/core/features/sift_extractor.h"
#include "server/core/forest/model_file.h"
#include "server/core/forest/sift_backtracking.h"
#include "server/core/localizer/localizer.h"
#include "server/core/localizer/query_options.h"
#include "server/core/pose/pnp.h"

namespace treeline::localizer {

// Answers with the colour camera's pose, in the scene's units. Any camera and
// image size will do: features become rays through the frame's own camera.
// Depth in a frame is ignored.
class SiftLocalizer final : public Localizer {
 public:
  // DATA_LOSS for a model without SIFT descriptors or without a viewing
  // distance.
  static absl::StatusOr<std::unique_ptr<SiftLocalizer>> Create(
      std::unique_ptr<const forest::ModelFile> model,
      const QueryOptions& options);

  absl::StatusOr<PoseEstimate> Localize(
      const image::Frame& frame, const LocalizeOptions& options) const override;
  const forest::ModelInfo& info() const override { return model_->info(); }

 private:
  // Features with a place in the scene, surest first.
  struct Matches;

  SiftLocalizer(std::unique_ptr<const forest::ModelFile> model,
                const QueryOptions& options);
  absl::StatusOr<Matches> Match(const features::SiftFeatures& features,
                                const camera::Camera& camera,
                                const std::stop_token& stop) const;
  // Fills in all but the timings.
  absl::Status Solve(const Matches& matches, const camera::Camera& camera,
                     const LocalizeOptions& options,
                     PoseEstimate& estimate) const;

  const std::unique_ptr<const forest::ModelFile> model_;
  const QueryOptions options_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_SIFT_LOCALIZER_H_
