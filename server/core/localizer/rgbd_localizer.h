// The thesis's chapter 4 on RGB-D frames: sample pixels, ask the backtracking
// forest for their scene coordinates, fit a pose.
#ifndef SERVER_CORE_LOCALIZER_RGBD_LOCALIZER_H_
#define SERVER_CORE_LOCALIZER_RGBD_LOCALIZER_H_

#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "server/core/features/rgbd_samples.h"
#include "server/core/forest/model_file.h"
#include "server/core/localizer/localizer.h"
#include "server/core/localizer/query_options.h"
#include "server/core/pose/scene_predictions.h"

namespace treeline {

class RgbdLocalizer final : public Localizer {
 public:
  RgbdLocalizer(std::unique_ptr<const ModelFile> model,
                const QueryOptions& options);
  ~RgbdLocalizer() override;

  absl::StatusOr<PoseEstimate> Localize(
      const Frame& frame, const LocalizeOptions& options) const override;
  const ModelInfo& info() const override { return model_->info(); }

 private:
  // Working memory of one query; kept for the next one.
  struct Scratch;
  class ScratchLease;

  absl::Status CheckFrame(const Frame& frame,
                          const RgbdCalibration& calibration) const;
  void Predict(const Scratch& scratch, ScenePredictions& scene) const;

  const std::unique_ptr<const ModelFile> model_;
  const QueryOptions options_;
  mutable absl::Mutex mutex_;
  mutable std::vector<std::unique_ptr<Scratch>> idle_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline

#endif  // SERVER_CORE_LOCALIZER_RGBD_LOCALIZER_H_
