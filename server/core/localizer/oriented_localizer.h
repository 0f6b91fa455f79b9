// Answers for frames that lie on their side or stand on their head.
#ifndef SERVER_CORE_LOCALIZER_ORIENTED_LOCALIZER_H_
#define SERVER_CORE_LOCALIZER_ORIENTED_LOCALIZER_H_

#include <memory>

#include "server/core/localizer/localizer.h"

namespace treeline::localizer {

// A localizer's answers to frames that are turned upright before it sees them:
// upright is how the scene's training frames are. Poses, correspondences and
// priors are those of the frame as it is.
//
// The frame's own orientation is tried first. Where that is a guess and does
// not give a pose that reaches the model's own threshold, the other turns are
// tried too: as it is, then clockwise, half round and counterclockwise, as
// often as cameras are held so. The best answer counts. A pose at another turn
// than the frame's has the odds of its confidence divided by kOtherTurnOdds
// before it is judged and compared: few pictures are turned, and whatever shows
// something else has three chances more to look like this place.
class OrientedLocalizer final : public Localizer {
 public:
  // other_turns: whether to try others than the frame's own.
  OrientedLocalizer(std::unique_ptr<const Localizer> upright, bool other_turns);

  // Timings are sums over the turns tried.
  absl::StatusOr<PoseEstimate> Localize(
      const image::Frame& frame, const LocalizeOptions& options) const override;
  const forest::ModelInfo& info() const override { return upright_->info(); }
  DepthUse depth_use() const override { return upright_->depth_use(); }
  const keyframes::KeyframeMap* keyframes() const override {
    return upright_->keyframes();
  }

 private:
  absl::StatusOr<PoseEstimate> LocalizeTurned(
      const image::Frame& frame, image::QuarterTurn turn,
      const LocalizeOptions& options) const;

  const std::unique_ptr<const Localizer> upright_;
  const bool other_turns_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_ORIENTED_LOCALIZER_H_
