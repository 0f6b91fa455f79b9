// One self-contained page about an evaluation: no script, no other file, no
// other host.
#ifndef SERVER_TOOLS_REPORT_H_
#define SERVER_TOOLS_REPORT_H_

#include <string>
#include <vector>

#include "server/tools/evaluated_method.h"
#include "server/tools/evaluation_run.h"
#include "server/tools/sweep.h"

namespace treeline {

struct ReportContents {
  EvaluationRun run;
  std::vector<EvaluatedMethod> methods;
  std::vector<Sweep> sweeps;
};

// The page. Of one method: headline figures, cumulative errors, errors frame by
// frame and against the distance from training, trajectory, latency, pictures
// with inliers and outliers, the worst frames. Of several: them side by side,
// and the same of each in a part that unfolds. Of both: scene-coordinate
// errors, sweeps, confidence and foreign pictures, published figures,
// provenance, command line.
std::string ReportHtml(const ReportContents& contents);

}  // namespace treeline

#endif  // SERVER_TOOLS_REPORT_H_
