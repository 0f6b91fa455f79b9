// Whether answers can be relied on: confidence and pictures from elsewhere.
#ifndef EVALUATION_REPORT_REPORT_TRUST_H_
#define EVALUATION_REPORT_REPORT_TRUST_H_

#include <string>
#include <vector>

#include "evaluation/accuracy/evaluated_method.h"
#include "evaluation/accuracy/evaluation_run.h"

namespace treeline::report {

// Reliability diagrams with precision and calibration error, and what became
// of foreign pictures. Empty if nothing is stated and nothing was asked.
std::string TrustSection(const std::vector<accuracy::EvaluatedMethod>& methods,
                         const accuracy::EvaluationRun& run);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_TRUST_H_
