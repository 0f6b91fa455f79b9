// One self-contained page about an evaluation: no script, no other file, no
// other host.
#ifndef SERVER_TOOLS_REPORT_H_
#define SERVER_TOOLS_REPORT_H_

#include <string>
#include <vector>

#include "common/geometry/rigid3.h"
#include "server/core/forest/model_info.h"
#include "server/tools/evaluation.h"
#include "server/tools/evaluation_json.h"
#include "server/tools/report_pictures.h"

namespace treeline {

struct ReportContents {
  EvaluationRun run;
  ModelInfo model;
  std::vector<FrameResult> results;
  std::vector<ReportPicture> pictures;
  // world_from_camera of the model's pose sensor; empty: not known.
  std::vector<Rigid3> training_poses;
};

// The page: headline figures, cumulative errors, errors frame by frame and
// against the distance from training, trajectory, latency, pictures with
// inliers and outliers, the worst frames, provenance, command line.
std::string ReportHtml(const ReportContents& contents);

}  // namespace treeline

#endif  // SERVER_TOOLS_REPORT_H_
