// Whether answers can be relied on: confidence and pictures from elsewhere.
#ifndef SERVER_TOOLS_REPORT_TRUST_H_
#define SERVER_TOOLS_REPORT_TRUST_H_

#include <string>
#include <vector>

#include "server/tools/evaluated_method.h"
#include "server/tools/evaluation_run.h"

namespace treeline {

// Reliability diagrams with precision and calibration error, and what became
// of foreign pictures. Empty if nothing is stated and nothing was asked.
std::string TrustSection(const std::vector<EvaluatedMethod>& methods,
                         const EvaluationRun& run);

}  // namespace treeline

#endif  // SERVER_TOOLS_REPORT_TRUST_H_
