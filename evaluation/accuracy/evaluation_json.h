// Results as JSON: the contract others script against
// (docs/reference/evaluation.md).
#ifndef EVALUATION_ACCURACY_EVALUATION_JSON_H_
#define EVALUATION_ACCURACY_EVALUATION_JSON_H_

#include <string>
#include <vector>

#include "evaluation/accuracy/evaluated_method.h"
#include "evaluation/accuracy/evaluation_run.h"
#include "evaluation/accuracy/sweep.h"
#include "nlohmann/json_fwd.hpp"
#include "server/core/forest/model_info.h"

namespace treeline::accuracy {

// One JSON object with a trailing newline. What is undefined, or not finite,
// is null. Angles are in degrees, lengths in metres, fractions in [0, 1].
std::string EvaluationJson(const EvaluatedMethod& method,
                           const std::vector<Sweep>& sweeps,
                           const EvaluationRun& run);

// The same for several methods: what is of the run once, and "methods" with
// what is of each. A method that failed has "name" and "error" alone.
std::string ComparisonJson(const std::vector<EvaluatedMethod>& methods,
                           const std::vector<Sweep>& sweeps,
                           const EvaluationRun& run);

// The object that ComparisonJson writes, for those who add to it.
nlohmann::ordered_json ComparisonDocument(
    const std::vector<EvaluatedMethod>& methods,
    const std::vector<Sweep>& sweeps, const EvaluationRun& run);

// What a model file says about itself, as one JSON object with a trailing
// newline.
std::string ModelInfoJson(const forest::ModelInfo& model);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_EVALUATION_JSON_H_
