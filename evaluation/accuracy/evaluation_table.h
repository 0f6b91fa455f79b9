// Results as a short table for a terminal.
#ifndef EVALUATION_ACCURACY_EVALUATION_TABLE_H_
#define EVALUATION_ACCURACY_EVALUATION_TABLE_H_

#include <string>
#include <vector>

#include "evaluation/accuracy/evaluated_method.h"
#include "evaluation/accuracy/evaluation_run.h"
#include "evaluation/accuracy/sweep.h"

namespace treeline::accuracy {

// Headline figures, one a line, and the first few errors with their files.
std::string EvaluationTable(const EvaluatedMethod& method,
                            const EvaluationRun& run);

// A line a method, and below it the errors of each.
std::string ComparisonTable(const std::vector<EvaluatedMethod>& methods,
                            const EvaluationRun& run);

// A line a point; empty if there is no sweep.
std::string SweepTable(const std::vector<Sweep>& sweeps);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_EVALUATION_TABLE_H_
