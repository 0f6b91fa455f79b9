#include "server/core/training/scene_writer.h"

#include "server/core/forest/model_file.h"

namespace treeline::training {
namespace {

template <typename T>
absl::string_view BytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()),
          values.size() * sizeof(T)};
}

}  // namespace

absl::Status WriteScene(const std::string& path, const forest::ModelInfo& info,
                        const std::vector<forest::ForestView>& forests,
                        const keyframes::Keyframes& keyframes,
                        absl::string_view descriptor) {
  std::vector<forest::ModelExtraBytes> extras = {
      {forest::ModelExtra::kKeyframes, BytesOf(keyframes.records)},
      {forest::ModelExtra::kKeyframePoints, BytesOf(keyframes.points)}};
  if (!keyframes.features.empty()) {
    extras.push_back(
        {forest::ModelExtra::kKeyframeFeatures, BytesOf(keyframes.features)});
  }
  keyframes::KeyframeWords words;
  if (!keyframes.features.empty() &&
      info.keyframe_sift == features::SiftKind::kFast) {
    words = keyframes::LearnWords(keyframes.features, keyframes.records.size());
    extras.push_back(
        {forest::ModelExtra::kKeyframeWords, BytesOf(words.means)});
    extras.push_back(
        {forest::ModelExtra::kKeyframeFeatureWords, BytesOf(words.word_of)});
  }
  if (!descriptor.empty()) {
    extras.push_back({forest::ModelExtra::kSceneDescriptor, descriptor});
  }
  return forest::WriteModel(path, info, forests, extras);
}

}  // namespace treeline::training
