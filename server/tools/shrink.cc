#include "server/tools/shrink.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "server/core/keyframes/keyframe_map.h"
#include "server/core/training/quantize_forest.h"
#include "server/core/training/tree_pruner.h"
#include "server/tools/model_description.h"

namespace treeline::tools {
namespace {

struct Step {
  uint32_t min_kept_samples;
  int feature_step;
};

// From what loses nothing to what loses most (docs/research/model-size.md).
constexpr Step kSteps[] = {{1, 1},   {3, 1},   {5, 1},   {5, 8},   {7, 16},
                           {10, 16}, {15, 16}, {25, 16}, {40, 32}, {80, 32}};

bool MayPrune(const forest::ModelFile& model) {
  const std::string& method = model.info().method;
  return method != "sift" && method != "points-lines";
}

absl::Status CheckScene(const forest::ModelFile& model) {
  if (model.info().part) {
    return absl::FailedPreconditionError(
        "a part of a scene cannot be made smaller; make the scene of all parts "
        "with `treeline merge` first");
  }
  const bool has_leaves = std::ranges::any_of(
      model.forest().payloads,
      [](const forest::LeafPayload& leaf) { return leaf.count > 0; });
  if (!has_leaves && MayPrune(model)) {
    return absl::FailedPreconditionError(
        "a base for `treeline train --adapt` has no leaves to leave out");
  }
  return absl::OkStatus();
}

forest::Forest Pruned(const forest::ForestView& forest, uint32_t min_samples) {
  std::vector<training::GrownTree> trees;
  for (int t = 0; t < forest.trees(); ++t) {
    trees.push_back(
        training::PruneTree(training::GrownTreeOf(forest, t), min_samples));
  }
  return training::QuantizeForest(std::move(trees));
}

// To the nearest multiple; of the last ones, 255.
void Coarsen(int step, std::vector<keyframes::KeyframeFeature>& features) {
  for (keyframes::KeyframeFeature& feature : features) {
    for (uint8_t& value : feature.descriptor) {
      value =
          static_cast<uint8_t>(std::min(255, (value + step / 2) / step * step));
    }
  }
}

void SetOption(const char* name, const std::string& value,
               forest::ModelInfo& info) {
  for (auto& [option, old] : info.options) {
    if (option != name) continue;
    old = value;
    return;
  }
  info.options.emplace_back(name, value);
}

absl::StatusOr<std::string> Encode(const forest::ModelFile& model, Step step) {
  forest::ModelInfo info = model.info();
  std::vector<forest::Forest> forests;
  std::vector<forest::ForestView> views;
  if (step.min_kept_samples > 1 && MayPrune(model)) {
    SetOption("min-kept-samples", absl::StrCat(step.min_kept_samples), info);
    for (size_t f = 0; f < model.forests(); ++f) {
      forests.push_back(Pruned(model.forest(f), step.min_kept_samples));
    }
    for (const forest::Forest& forest : forests) {
      views.push_back(forest.View());
    }
  } else {
    for (size_t f = 0; f < model.forests(); ++f) {
      views.push_back(model.forest(f));
    }
  }
  std::vector<keyframes::KeyframeFeature> features;
  std::vector<forest::ModelExtraBytes> extras;
  for (const forest::SectionSize& section : model.sections()) {
    const auto kind = static_cast<forest::ModelExtra>(section.kind);
    if (kind < forest::ModelExtra::kKeyframes) continue;
    TL_ASSIGN_OR_RETURN(const std::span<const char> bytes,
                        model.Extra<char>(kind));
    extras.push_back({kind, {bytes.data(), bytes.size()}});
    if (kind != forest::ModelExtra::kKeyframeFeatures ||
        step.feature_step == 1) {
      continue;
    }
    TL_ASSIGN_OR_RETURN(const auto given,
                        model.Extra<keyframes::KeyframeFeature>(kind));
    features.assign(given.begin(), given.end());
    Coarsen(step.feature_step, features);
    SetOption("feature-step", absl::StrCat(step.feature_step), info);
    extras.back().bytes = {reinterpret_cast<const char*>(features.data()),
                           features.size() * sizeof(features[0])};
  }
  return forest::EncodeModel(info, views, extras);
}

}  // namespace

absl::StatusOr<ShrunkModel> ShrinkModel(const forest::ModelFile& model,
                                        uint64_t max_bytes) {
  TL_RETURN_IF_ERROR(CheckScene(model));
  uint64_t least_bytes = 0;
  for (const Step& step : kSteps) {
    TL_ASSIGN_OR_RETURN(std::string file, Encode(model, step));
    least_bytes = file.size();
    if (file.size() <= max_bytes) {
      return ShrunkModel{std::move(file), step.min_kept_samples,
                         step.feature_step};
    }
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "the model cannot be made that small; the least is ",
      FormatBytes(least_bytes),
      MayPrune(model)
          ? ". `treeline inspect` shows what takes it"
          : absl::StrCat(", since nothing is left out of the leaves of method ",
                         model.info().method)));
}

}  // namespace treeline::tools
