// The stage "report": what the pipeline found, as the answer.
#ifndef SERVER_CORE_LOCALIZER_REPORT_H_
#define SERVER_CORE_LOCALIZER_REPORT_H_

#include "server/core/localizer/candidate.h"
#include "server/core/localizer/localizer.h"
#include "server/core/localizer/pose_verifier.h"

namespace treeline::localizer {

// `verdict` is the candidate's; null if it has no pose, and then the candidate
// says why.
PoseEstimate Report(Candidate candidate, const Verdict* verdict);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_REPORT_H_
