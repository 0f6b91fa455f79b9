// `treeline learn --live`.
#ifndef SERVER_TOOLS_APP_LEARN_LIVE_H_
#define SERVER_TOOLS_APP_LEARN_LIVE_H_

#include <stop_token>

#include "absl/status/status.h"
#include "server/tools/app/learn_run.h"

namespace treeline::tools_app {

// Learns options.source, a recording that is played at its pace or "-" for
// frames that standard input names, while the frames arrive. A version in the
// repository has the model so far, renewed every few seconds, and the complete
// one soon after the last frame. `stop` ends the frames, not the learning.
//
// Errors: those of opening the source; FAILED_PRECONDITION if the cameras are
// not known, or no frame could be learnt. If no model was written, no version
// is left.
absl::Status LearnLive(const LearnOptions& options,
                       const std::stop_token& stop);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_LEARN_LIVE_H_
