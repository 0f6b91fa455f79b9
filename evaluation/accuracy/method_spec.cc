#include "evaluation/accuracy/method_spec.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "server/core/training/scene_trainer.h"

namespace treeline::accuracy {
namespace {

constexpr const char* kUnbalanced = "ubrf";
constexpr const char* kNoBacktracking = "brf";

std::vector<std::string> Names() {
  std::vector<std::string> names;
  for (const training::MethodDescription& method :
       training::TrainableMethods()) {
    names.emplace_back(method.name);
  }
  names.insert(
      names.end(),
      {BaselineName(FeatureKind::kSift), BaselineName(FeatureKind::kOrb),
       BaselineName(FeatureKind::kFastSift), kUnbalanced, kNoBacktracking});
  return names;
}

}  // namespace

std::string ComparableNames() { return absl::StrJoin(Names(), ", "); }

absl::StatusOr<MethodSpec> ParseMethod(absl::string_view text) {
  MethodSpec spec;
  const size_t equals = text.find('=');
  if (equals != absl::string_view::npos && equals > 0 &&
      equals + 1 < text.size()) {
    spec.name = std::string(text.substr(0, equals));
    spec.model_path = std::string(text.substr(equals + 1));
    return spec;
  }
  spec.name = std::string(text);
  spec.baseline = BaselineOfName(text);
  if (spec.baseline) return spec;
  if (text == kUnbalanced || text == kNoBacktracking) {
    spec.trained_method = "rgbd";
    spec.backtracking_leaves = 1;
    if (text == kUnbalanced) spec.balanced_levels = 0;
    return spec;
  }
  for (const training::MethodDescription& method :
       training::TrainableMethods()) {
    if (text != method.name) continue;
    spec.trained_method = method.name;
    return spec;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("\"", text, "\" cannot be compared: it must be one of ",
                   ComparableNames(), ", or NAME=FILE for a model file"));
}

absl::StatusOr<std::vector<MethodSpec>> ParseMethods(absl::string_view text) {
  std::vector<MethodSpec> specs;
  for (const absl::string_view name : absl::StrSplit(text, ',')) {
    absl::StatusOr<MethodSpec> spec = ParseMethod(name);
    if (!spec.ok()) return spec.status();
    const bool twice = std::ranges::any_of(specs, [&](const MethodSpec& other) {
      return other.name == spec->name;
    });
    if (twice) {
      return absl::InvalidArgumentError(
          absl::StrCat("\"", spec->name, "\" is named twice"));
    }
    specs.push_back(*std::move(spec));
  }
  return specs;
}

training::TrainingOptions TrainingFor(const MethodSpec& spec,
                                      training::TrainingOptions training) {
  if (spec.balanced_levels) training.balanced_levels = *spec.balanced_levels;
  return training;
}

localizer::QueryOptions QueriesFor(const MethodSpec& spec,
                                   localizer::QueryOptions query) {
  if (spec.backtracking_leaves) {
    query.backtracking_leaves = *spec.backtracking_leaves;
  }
  return query;
}

MethodInputs InputsOfMethod(absl::string_view method) {
  if (method == "rgbd" || method == "points-lines") return {"RGB-D", "RGB-D"};
  if (method == "universal") return {"RGB-D", "RGB-D or RGB"};
  if (method == "rgb" || method == "hybrid") return {"RGB-D", "RGB"};
  if (method == "sift") return {"RGB", "RGB"};
  if (BaselineOfName(method)) return {"RGB-D", "RGB"};
  return {};
}

}  // namespace treeline::accuracy
