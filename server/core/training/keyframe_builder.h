// Which training frames a model keeps, and what of them.
#ifndef SERVER_CORE_TRAINING_KEYFRAME_BUILDER_H_
#define SERVER_CORE_TRAINING_KEYFRAME_BUILDER_H_

#include <stop_token>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/dataset.h"
#include "server/core/keyframes/keyframe_map.h"

namespace treeline::training {

struct KeyframeOptions {
  // A frame is kept if every kept one is further away than this, in the
  // distance of KeyframeMap::Nearest (m).
  double spacing_m = 0.25;
  // At most so many, evenly thinned.
  int max_keyframes = 1600;
  // At most so many points of each.
  int points = 1200;
  // At most so many SIFT features of each, where depth is measured; 0: none,
  // and none are looked for.
  int features = 0;
  features::SiftKind sift = features::SiftKind::kFast;
  // 0: one a processor.
  int threads = 0;
};

// Keyframes of the frames that have depth and a pose. Points stand on the
// strongest edges of each cell of a grid, where depth is measured and smooth.
// The result does not depend on threads. CANCELLED after `stop`, and whatever
// reading a frame gives.
absl::StatusOr<keyframes::Keyframes> BuildKeyframes(
    const dataset::Dataset& dataset, const camera::RgbdCalibration& calibration,
    const KeyframeOptions& options, bool quiet, const std::stop_token& stop);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_KEYFRAME_BUILDER_H_
