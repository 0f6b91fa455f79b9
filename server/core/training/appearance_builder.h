// What a scene looks like, from its training images.
#ifndef SERVER_CORE_TRAINING_APPEARANCE_BUILDER_H_
#define SERVER_CORE_TRAINING_APPEARANCE_BUILDER_H_

#include <stop_token>

#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"
#include "server/core/recognition/scene_descriptor.h"

namespace treeline::training {

struct AppearanceOptions {
  // At most so many, evenly spread: the more images, the more words a scene
  // has in common with others by chance. Positive.
  int max_images = 500;
  // 0: one a processor.
  int threads = 0;
};

// The words of the frames that have a pose. The result does not depend on
// threads. CANCELLED after `stop`, and whatever reading a frame gives.
absl::StatusOr<recognition::SceneDescriptor> BuildSceneDescriptor(
    const dataset::Dataset& dataset, const AppearanceOptions& options,
    bool quiet, const std::stop_token& stop);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_APPEARANCE_BUILDER_H_
