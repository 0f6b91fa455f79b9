// The cameras in space, on a turntable: ground truth against estimates.
#ifndef SERVER_TOOLS_REPORT_TURNTABLE_H_
#define SERVER_TOOLS_REPORT_TURNTABLE_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/geometry/rigid3.h"
#include "server/tools/evaluation.h"

namespace treeline {

// The true path and every few frusta, true and estimated, seen somewhat from
// above, with the training cameras faintly. Radio buttons, which need no
// script, choose one of twelve directions. Empty if no frame has ground truth.
// id: unique on the page, of letters, digits and dashes.
std::string TurntableChart(const std::vector<FrameResult>& results,
                           const std::vector<Rigid3>& training_poses,
                           absl::string_view id);

}  // namespace treeline

#endif  // SERVER_TOOLS_REPORT_TURNTABLE_H_
