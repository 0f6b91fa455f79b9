// The thesis's chapter 5: sample pixels of the whole image and of its line
// segments, ask a forest for the scene coordinates of each kind, and fit a pose
// to points on points and points on lines together.
#ifndef SERVER_CORE_LOCALIZER_POINTS_LINES_LOCALIZER_H_
#define SERVER_CORE_LOCALIZER_POINTS_LINES_LOCALIZER_H_

#include <memory>

#include "absl/status/statusor.h"
#include "server/core/features/line_segments.h"
#include "server/core/forest/model_file.h"
#include "server/core/localizer/forest_query.h"
#include "server/core/localizer/localizer.h"
#include "server/core/localizer/pose_verifier.h"
#include "server/core/localizer/query_options.h"

namespace treeline::localizer {

class PointsLinesLocalizer final : public Localizer {
 public:
  // DATA_LOSS unless the model has two forests with as many trees each.
  static absl::StatusOr<std::unique_ptr<PointsLinesLocalizer>> Create(
      std::unique_ptr<const forest::ModelFile> model, PoseVerifier verifier,
      const QueryOptions& options);

  // Without line segments in the frame, general points alone decide.
  absl::StatusOr<PoseEstimate> Localize(
      const image::Frame& frame, const LocalizeOptions& options) const override;
  const forest::ModelInfo& info() const override { return model_->info(); }

 private:
  // Working memory of one query.
  struct Scratch {
    ForestScratch forest;
    features::LinePoints segments;  // all points on line segments
    features::LinePoints lines;     // those sampled
  };

  PointsLinesLocalizer(std::unique_ptr<const forest::ModelFile> model,
                       PoseVerifier verifier, const QueryOptions& options);

  // Samples points on lines, at most half of all, in `lines`, and general ones
  // in forest.samples.
  void Sample(const image::Frame& frame,
              const camera::RgbdCalibration& calibration, uint64_t seed,
              Scratch& scratch) const;
  // Predictions for both, shuffled together; forest.samples becomes theirs.
  absl::StatusOr<pose::ScenePredictions> Predict(const LocalizeOptions& options,
                                                 Scratch& scratch) const;

  const std::unique_ptr<const forest::ModelFile> model_;
  const PoseVerifier verifier_;
  const QueryOptions options_;
  mutable Pool<Scratch> scratch_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_POINTS_LINES_LOCALIZER_H_
