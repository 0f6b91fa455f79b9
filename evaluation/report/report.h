// One self-contained page about an evaluation: no script, no other file, no
// other host.
#ifndef EVALUATION_REPORT_REPORT_H_
#define EVALUATION_REPORT_REPORT_H_

#include <string>
#include <vector>

#include "evaluation/accuracy/evaluated_method.h"
#include "evaluation/accuracy/evaluation_run.h"
#include "evaluation/accuracy/sweep.h"

namespace treeline::report {

struct ReportContents {
  accuracy::EvaluationRun run;
  std::vector<accuracy::EvaluatedMethod> methods;
  std::vector<accuracy::Sweep> sweeps;
};

// The page. Of one method: headline figures, cumulative errors, errors frame by
// frame and against the distance from training, trajectory, latency, pictures
// with inliers and outliers, the worst frames. Of several: them side by side,
// and the same of each in a part that unfolds. Of both: scene-coordinate
// errors, sweeps, confidence and foreign pictures, published figures,
// provenance, command line.
std::string ReportHtml(const ReportContents& contents);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_H_
