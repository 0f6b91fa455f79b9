// What can be compared: methods that are trained, their ablations, baselines,
// and model files that are there already.
#ifndef EVALUATION_ACCURACY_METHOD_SPEC_H_
#define EVALUATION_ACCURACY_METHOD_SPEC_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "evaluation/accuracy/feature_pnp_baseline.h"
#include "server/core/localizer/query_options.h"
#include "server/core/training/training_options.h"

namespace treeline::accuracy {

// One entry of --compare.
struct MethodSpec {
  std::string name;  // as the report calls it
  // One of these three.
  std::string trained_method;  // one of TrainableMethods()
  std::optional<FeatureKind> baseline;
  std::string model_path;
  // What an ablation changes.
  std::optional<int> balanced_levels;
  std::optional<int> backtracking_leaves;

  bool NeedsTraining() const { return !trained_method.empty(); }
};

// A name of TrainableMethods(); sift-pnp or orb-pnp; ubrf (rgbd without
// balanced levels and without backtracking) or brf (rgbd without
// backtracking); or NAME=FILE for a model file. INVALID_ARGUMENT for anything
// else, with the list of names.
absl::StatusOr<MethodSpec> ParseMethod(absl::string_view text);

// Names separated by commas. INVALID_ARGUMENT also for none, and for one twice.
absl::StatusOr<std::vector<MethodSpec>> ParseMethods(absl::string_view text);

// The options of this method where the others' are `training` and `query`.
training::TrainingOptions TrainingFor(const MethodSpec& spec,
                                      training::TrainingOptions training);
localizer::QueryOptions QueriesFor(const MethodSpec& spec,
                                   localizer::QueryOptions query);

// Every name, separated by commas: for messages and help.
std::string ComparableNames();

// What a method of this name looks at in training and in a query: "RGB-D",
// "RGB", or "" for a method that is not known here.
struct MethodInputs {
  std::string training;
  std::string query;
};
MethodInputs InputsOfMethod(absl::string_view method);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_METHOD_SPEC_H_
