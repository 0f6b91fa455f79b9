// Models with keyframes that a test makes up.
#ifndef SERVER_CORE_KEYFRAMES_TESTING_KEYFRAME_MODEL_H_
#define SERVER_CORE_KEYFRAMES_TESTING_KEYFRAME_MODEL_H_

#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "gtest/gtest.h"
#include "server/core/forest/model_file.h"
#include "server/core/keyframes/keyframe_map.h"

namespace treeline::keyframes {

// A model of one leaf with these keyframes, which must outlive what is read of
// it.
inline absl::StatusOr<std::unique_ptr<const forest::ModelFile>>
ModelWithKeyframes(const Keyframes& keyframes,
                   const forest::ModelInfo& info = {}) {
  forest::Forest forest;
  forest.nodes = {forest::Node::Leaf(0)};
  forest.tree_offsets = {0, 1};
  forest.descriptors.resize(1);
  forest.payloads.resize(1);
  const auto bytes = [](const auto& values) {
    return absl::string_view(reinterpret_cast<const char*>(values.data()),
                             values.size() * sizeof(values[0]));
  };
  const std::string path =
      testing::TempDir() + "/keyframe_model_" + std::to_string(getpid());
  const absl::Status written = forest::WriteModel(
      path, info, {forest.View()},
      {{{forest::ModelExtra::kKeyframes, bytes(keyframes.records)},
        {forest::ModelExtra::kKeyframePoints, bytes(keyframes.points)},
        {forest::ModelExtra::kKeyframeFeatures, bytes(keyframes.features)}}});
  if (!written.ok()) return written;
  auto model = forest::ModelFile::Open(path);
  std::filesystem::remove(path);
  return model;
}

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_TESTING_KEYFRAME_MODEL_H_
