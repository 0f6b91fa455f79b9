// Methods side by side, on the evaluation's page.
#ifndef SERVER_TOOLS_REPORT_COMPARISON_H_
#define SERVER_TOOLS_REPORT_COMPARISON_H_

#include <string>
#include <vector>

#include "server/tools/evaluated_method.h"
#include "server/tools/evaluation_run.h"
#include "server/tools/sweep.h"

namespace treeline {

// "5 methods on 180 frames. ..." and, of the best one, the figures.
std::string ComparisonVerdict(const std::vector<EvaluatedMethod>& methods);

// A row a method, in the form of the thesis's tables, the best figure of each
// column in bold; and cumulative pose errors of all of them.
std::string ComparisonSection(const std::vector<EvaluatedMethod>& methods,
                              const EvaluationRun& run);

// Accuracy and time as options change. Empty if nothing was swept.
std::string SweepSection(const std::vector<Sweep>& sweeps);

// What others published for this kind of recording, with the protocol, and
// the methods' own figures first. Empty if nothing is known.
std::string PublishedSection(const std::vector<EvaluatedMethod>& methods,
                             const EvaluationRun& run);

}  // namespace treeline

#endif  // SERVER_TOOLS_REPORT_COMPARISON_H_
