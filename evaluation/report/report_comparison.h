// Methods side by side, on the evaluation's page.
#ifndef EVALUATION_REPORT_REPORT_COMPARISON_H_
#define EVALUATION_REPORT_REPORT_COMPARISON_H_

#include <string>
#include <vector>

#include "evaluation/accuracy/evaluated_method.h"
#include "evaluation/accuracy/evaluation_run.h"
#include "evaluation/accuracy/sweep.h"

namespace treeline::report {

// "5 methods on 180 frames. ..." and, of the best one, the figures.
std::string ComparisonVerdict(
    const std::vector<accuracy::EvaluatedMethod>& methods);

// A row a method, in the form of the thesis's tables, the best figure of each
// column in bold; and cumulative pose errors of all of them.
std::string ComparisonSection(
    const std::vector<accuracy::EvaluatedMethod>& methods,
    const accuracy::EvaluationRun& run);

// Accuracy and time as options change. Empty if nothing was swept.
std::string SweepSection(const std::vector<accuracy::Sweep>& sweeps);

// What others published for this kind of recording, with the protocol, and
// the methods' own figures first. Empty if nothing is known.
std::string PublishedSection(
    const std::vector<accuracy::EvaluatedMethod>& methods,
    const accuracy::EvaluationRun& run);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_COMPARISON_H_
