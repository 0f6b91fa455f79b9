// The cameras in space, on a turntable: ground truth against estimates.
#ifndef EVALUATION_REPORT_REPORT_TURNTABLE_H_
#define EVALUATION_REPORT_REPORT_TURNTABLE_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/geometry/rigid3.h"
#include "evaluation/accuracy/evaluation.h"

namespace treeline::report {

// The true path and every few frusta, true and estimated, seen somewhat from
// above, with the training cameras faintly. Radio buttons, which need no
// script, choose one of twelve directions. Empty if no frame has ground truth.
// id: unique on the page, of letters, digits and dashes.
std::string TurntableChart(const std::vector<accuracy::FrameResult>& results,
                           const std::vector<geometry::Rigid3>& training_poses,
                           absl::string_view id);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_TURNTABLE_H_
