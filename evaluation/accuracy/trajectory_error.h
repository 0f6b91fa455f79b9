// The absolute trajectory error: how far estimated camera positions are from
// the true ones, also where the two worlds need not be the same.
#ifndef EVALUATION_ACCURACY_TRAJECTORY_ERROR_H_
#define EVALUATION_ACCURACY_TRAJECTORY_ERROR_H_

#include <optional>
#include <vector>

#include "evaluation/accuracy/evaluation.h"

namespace treeline::accuracy {

enum class TrajectoryAlignment {
  kNone,        // S of Eq. 4.6 is the identity
  kRigid,       // a rotation and a translation
  kSimilarity,  // ... and a scale
};

struct TrajectoryError {
  int poses = 0;
  // Root mean square of |scale * R p_i + t - q_i| over estimated positions p
  // and true ones q (thesis Eq. 4.6 and 4.7; world units, metres indoors).
  double rmse_m = 0;
  // Of the alignment: true lengths per estimated one. 1 unless kSimilarity.
  double scale = 1;
};

// Over localized frames with ground truth. The alignment is the one of least
// rmse_m (Horn 1987). nullopt: no such frame or, where something is to be
// aligned, fewer than three, or all of them on a line.
std::optional<TrajectoryError> AbsoluteTrajectoryError(
    const std::vector<FrameResult>& results, TrajectoryAlignment alignment);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_TRAJECTORY_ERROR_H_
