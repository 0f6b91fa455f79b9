// What the evaluation's page says about one method.
#ifndef EVALUATION_REPORT_REPORT_METHOD_H_
#define EVALUATION_REPORT_REPORT_METHOD_H_

#include <string>

#include "absl/strings/string_view.h"
#include "evaluation/accuracy/evaluated_method.h"
#include "evaluation/accuracy/evaluation_run.h"

namespace treeline::report {

// "178 of 180 frames were placed within 5 cm and 5°. ..."
std::string MethodVerdict(const accuracy::EvaluatedMethod& method);

// The headline figures.
std::string MethodTiles(const accuracy::EvaluatedMethod& method);

// Cumulative errors, errors frame by frame and against the distance from
// training, pictures with inliers and outliers, trajectory, latency, the worst
// frames. id: a name for this method that no other on the page has, of letters,
// digits and dashes.
std::string MethodSections(const accuracy::EvaluatedMethod& method,
                           const accuracy::EvaluationRun& run,
                           absl::string_view id);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_METHOD_H_
