// The trajectory errors of evaluated frames.
#ifndef EVALUATION_ACCURACY_TRAJECTORY_ERROR_H_
#define EVALUATION_ACCURACY_TRAJECTORY_ERROR_H_

#include <vector>

#include "common/dataset/trajectory_error.h"
#include "evaluation/accuracy/evaluation.h"

namespace treeline::accuracy {

// Estimated and true poses of the localized frames with ground truth, in order.
std::vector<dataset::PosePair> PosePairs(
    const std::vector<FrameResult>& results);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_TRAJECTORY_ERROR_H_
