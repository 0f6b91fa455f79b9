// Accuracy and time as one option changes (thesis Fig. 4.7, 4.8, 4.10, 4.16).
#ifndef EVALUATION_ACCURACY_SWEEP_H_
#define EVALUATION_ACCURACY_SWEEP_H_

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "evaluation/accuracy/evaluation.h"
#include "server/core/localizer/localizer.h"

namespace treeline::accuracy {

// What is swept. The first three change queries alone, trees a trained model;
// only balanced levels need training for every point.
enum class SweepVariable {
  kBacktracking,
  kSamples,
  kHypotheses,
  kTrees,
  kBalancedLevels,
};

// "backtracking", "samples", "hypotheses", "trees", "balanced-levels".
const char* SweepName(SweepVariable variable);
// The axis of a chart: "leaves visited in each tree" and so on.
const char* SweepAxis(SweepVariable variable);

struct SweepRequest {
  SweepVariable variable = SweepVariable::kBacktracking;
  std::vector<int> values;  // ascending, without repetition
};

// Sets the option of queries that the variable is, if it is one.
void SetQueryOption(SweepVariable variable, int value,
                    localizer::QueryOptions& query);

// "NAME=LOW..HIGH", "NAME=LOW..HIGH:STEP", or "NAME=a,b,c". INVALID_ARGUMENT
// for anything else, for more than 200 values, and for values that the option
// does not allow.
absl::StatusOr<SweepRequest> ParseSweep(absl::string_view text);

struct SweepPoint {
  int value = 0;
  EvaluationSummary summary;
  double training_s = 0;  // of this point's model
  uint64_t model_bytes = 0;
};

// One method's line in a chart.
struct SweepLine {
  std::string method;
  std::vector<SweepPoint> points;
};

struct Sweep {
  SweepVariable variable = SweepVariable::kBacktracking;
  std::vector<SweepLine> lines;
};

// A copy of a model file with its first `trees` trees alone. Trees are
// independent of each other, so that this is what training so many would have
// given, but for the quantisation of leaf positions, which follows the bounds
// of all trees. INVALID_ARGUMENT if the model has fewer; and whatever reading
// and writing give.
absl::Status WriteFirstTrees(const std::string& model_path, int trees,
                             const std::string& output_path);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_SWEEP_H_
