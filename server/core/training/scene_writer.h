// A scene that was learnt from frames with depth, as a model file.
#ifndef SERVER_CORE_TRAINING_SCENE_WRITER_H_
#define SERVER_CORE_TRAINING_SCENE_WRITER_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "server/core/forest/forest.h"
#include "server/core/forest/model_info.h"
#include "server/core/keyframes/keyframe_map.h"

namespace treeline::training {

// Writes it atomically, with the words of the keyframes' features where they
// are FastSift's. `descriptor`: as SceneDescriptor::Serialize gives it; empty:
// none. Errors of forest::WriteModel.
absl::Status WriteScene(const std::string& path, const forest::ModelInfo& info,
                        const std::vector<forest::ForestView>& forests,
                        const keyframes::Keyframes& keyframes,
                        absl::string_view descriptor);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_SCENE_WRITER_H_
