// Results as a short table for a terminal.
#ifndef SERVER_TOOLS_EVALUATION_TABLE_H_
#define SERVER_TOOLS_EVALUATION_TABLE_H_

#include <string>
#include <vector>

#include "server/tools/evaluated_method.h"
#include "server/tools/evaluation_run.h"
#include "server/tools/sweep.h"

namespace treeline {

// Headline figures, one a line, and the first few errors with their files.
std::string EvaluationTable(const EvaluatedMethod& method,
                            const EvaluationRun& run);

// A line a method, and below it the errors of each.
std::string ComparisonTable(const std::vector<EvaluatedMethod>& methods,
                            const EvaluationRun& run);

// A line a point; empty if there is no sweep.
std::string SweepTable(const std::vector<Sweep>& sweeps);

}  // namespace treeline

#endif  // SERVER_TOOLS_EVALUATION_TABLE_H_
