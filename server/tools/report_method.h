// What the evaluation's page says about one method.
#ifndef SERVER_TOOLS_REPORT_METHOD_H_
#define SERVER_TOOLS_REPORT_METHOD_H_

#include <string>

#include "absl/strings/string_view.h"
#include "server/tools/evaluated_method.h"
#include "server/tools/evaluation_run.h"

namespace treeline {

// "178 of 180 frames were placed within 5 cm and 5°. ..."
std::string MethodVerdict(const EvaluatedMethod& method);

// The headline figures.
std::string MethodTiles(const EvaluatedMethod& method);

// Cumulative errors, errors frame by frame and against the distance from
// training, pictures with inliers and outliers, trajectory, latency, the worst
// frames. id: a name for this method that no other on the page has, of letters,
// digits and dashes.
std::string MethodSections(const EvaluatedMethod& method,
                           const EvaluationRun& run, absl::string_view id);

}  // namespace treeline

#endif  // SERVER_TOOLS_REPORT_METHOD_H_
