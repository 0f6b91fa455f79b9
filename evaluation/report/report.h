// The data of an evaluation's report, from which a page is made (see
// report_page.h and evaluation/report).
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

// One JSON object: what ComparisonJson has, of one method too, and
//   kind            "evaluation"
//   heat_map_scale  max_m, and colours from 0 to it
//   published       figures of others for this kind of recording, or null
//   sweeps[].axis   what is swept, in words
//   methods[].per_frame[].training_distance
//                   to the nearest training camera, or null
//   methods[].page  what only a page shows: inputs, model_description, axes
//                   (unit vectors in the world), training_positions (m),
//                   pictures and heat_maps (images as data URIs, pixels as x,
//                   y, x, y, ...), splits (by level), scene_error_curve (m,
//                   share)
// The keys with their types: evaluation/report/src/model/report_data.ts.
std::string ReportJson(const ReportContents& contents);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_H_
