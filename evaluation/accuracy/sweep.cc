#include "evaluation/accuracy/sweep.h"

#include <algorithm>
#include <span>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/status_macros.h"
#include "server/core/forest/model_file.h"
#include "server/core/training/training_options.h"

namespace treeline::accuracy {
namespace {

constexpr size_t kMaxValues = 200;
constexpr SweepVariable kVariables[] = {
    SweepVariable::kBacktracking, SweepVariable::kSamples,
    SweepVariable::kHypotheses, SweepVariable::kTrees,
    SweepVariable::kBalancedLevels};

absl::Status BadSweep(absl::string_view text, absl::string_view reason) {
  return absl::InvalidArgumentError(
      absl::StrCat("sweep \"", text, "\": ", reason));
}

// Whether the option may have this value.
absl::Status CheckValue(SweepVariable variable, int value) {
  localizer::QueryOptions query;
  training::TrainingOptions training;
  SetQueryOption(variable, value, query);
  if (variable == SweepVariable::kTrees) training.trees = value;
  if (variable == SweepVariable::kBalancedLevels) {
    training.balanced_levels = value;
  }
  TL_RETURN_IF_ERROR(query.Validate());
  return training.Validate();
}

absl::StatusOr<std::vector<int>> ParseValues(absl::string_view text) {
  const auto bad = [&] {
    return absl::InvalidArgumentError(absl::StrCat(
        "\"", text, "\" is neither LOW..HIGH[:STEP] nor a list of numbers"));
  };
  std::vector<int> values;
  const size_t dots = text.find("..");
  if (dots == absl::string_view::npos) {
    for (const absl::string_view word : absl::StrSplit(text, ',')) {
      int value = 0;
      if (!absl::SimpleAtoi(word, &value)) return bad();
      values.push_back(value);
    }
  } else {
    const std::pair<absl::string_view, absl::string_view> high_step =
        absl::StrSplit(text.substr(dots + 2), absl::MaxSplits(':', 1));
    int low = 0;
    int high = 0;
    int step = 1;
    if (!absl::SimpleAtoi(text.substr(0, dots), &low) ||
        !absl::SimpleAtoi(high_step.first, &high) || low > high ||
        (text.find(':') != absl::string_view::npos &&
         (!absl::SimpleAtoi(high_step.second, &step) || step < 1))) {
      return bad();
    }
    for (int64_t v = low; v <= high && values.size() <= kMaxValues; v += step) {
      values.push_back(static_cast<int>(v));
    }
  }
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

}  // namespace

const char* SweepName(SweepVariable variable) {
  switch (variable) {
    case SweepVariable::kBacktracking:
      return "backtracking";
    case SweepVariable::kSamples:
      return "samples";
    case SweepVariable::kHypotheses:
      return "hypotheses";
    case SweepVariable::kTrees:
      return "trees";
    case SweepVariable::kBalancedLevels:
      return "balanced-levels";
  }
  return "";
}

const char* SweepAxis(SweepVariable variable) {
  switch (variable) {
    case SweepVariable::kBacktracking:
      return "leaves visited in each tree";
    case SweepVariable::kSamples:
      return "pixels sampled a query";
    case SweepVariable::kHypotheses:
      return "pose hypotheses a query";
    case SweepVariable::kTrees:
      return "trees";
    case SweepVariable::kBalancedLevels:
      return "levels split by the balanced objective";
  }
  return "";
}

void SetQueryOption(SweepVariable variable, int value,
                    localizer::QueryOptions& query) {
  switch (variable) {
    case SweepVariable::kBacktracking:
      query.backtracking_leaves = value;
      break;
    case SweepVariable::kSamples:
      query.samples = value;
      break;
    case SweepVariable::kHypotheses:
      query.hypotheses = value;
      break;
    case SweepVariable::kTrees:
    case SweepVariable::kBalancedLevels:
      break;
  }
}

absl::StatusOr<SweepRequest> ParseSweep(absl::string_view text) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(text, absl::MaxSplits('=', 1));
  const auto variable = std::ranges::find_if(
      kVariables, [&](SweepVariable v) { return parts.first == SweepName(v); });
  if (variable == std::end(kVariables)) {
    return BadSweep(text,
                    "it must begin with backtracking=, samples=, hypotheses=, "
                    "trees= or balanced-levels=");
  }
  SweepRequest request{.variable = *variable, .values = {}};
  absl::StatusOr<std::vector<int>> values = ParseValues(parts.second);
  if (!values.ok()) return BadSweep(text, values.status().message());
  if (values->empty()) return BadSweep(text, "there are no values");
  if (values->size() > kMaxValues) {
    return BadSweep(text, absl::StrCat("more than ", kMaxValues, " values"));
  }
  for (int value : *values) {
    const absl::Status allowed = CheckValue(*variable, value);
    if (!allowed.ok()) return BadSweep(text, allowed.message());
  }
  request.values = *std::move(values);
  return request;
}

absl::Status WriteFirstTrees(const std::string& model_path, int trees,
                             const std::string& output_path) {
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<const forest::ModelFile> model,
                      forest::ModelFile::Open(model_path));
  std::vector<forest::ForestView> forests;
  for (size_t f = 0; f < model->forests(); ++f) {
    forest::ForestView forest = model->forest(f);
    if (trees < 1 || trees > forest.trees()) {
      return absl::InvalidArgumentError(absl::StrCat(
          model_path, " has ", forest.trees(), " trees, not ", trees));
    }
    const auto kept = static_cast<size_t>(trees);
    forest.nodes = forest.nodes.first(forest.tree_offsets[kept]);
    forest.tree_offsets = forest.tree_offsets.first(kept + 1);
    // Modes stand in the order of their trees.
    uint32_t modes = 0;
    for (const forest::Node& node : forest.nodes) {
      if (node.is_leaf()) modes = std::max(modes, node.leaf() + node.modes());
    }
    forest.payloads = forest.payloads.first(modes);
    if (!forest.descriptors.empty()) {
      forest.descriptors = forest.descriptors.first(modes);
    }
    if (!forest.sift_descriptors.empty()) {
      forest.sift_descriptors = forest.sift_descriptors.first(modes);
    }
    forests.push_back(forest);
  }
  std::vector<forest::ModelExtraBytes> extras;
  for (forest::ModelExtra kind :
       {forest::ModelExtra::kKeyframes, forest::ModelExtra::kKeyframePoints,
        forest::ModelExtra::kKeyframeFeatures}) {
    TL_ASSIGN_OR_RETURN(const std::span<const char> bytes,
                        model->Extra<char>(kind));
    if (!bytes.empty()) {
      extras.push_back({kind, absl::string_view(bytes.data(), bytes.size())});
    }
  }
  return forest::WriteModel(output_path, model->info(), forests, extras);
}

}  // namespace treeline::accuracy
