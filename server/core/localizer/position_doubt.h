// How far off a pose may be that all evidence speaks for, since what is seen
// does not determine it any better.
#ifndef SERVER_CORE_LOCALIZER_POSITION_DOUBT_H_
#define SERVER_CORE_LOCALIZER_POSITION_DOUBT_H_

#include <optional>

#include "common/geometry/rigid3.h"
#include "server/core/localizer/localizer.h"

namespace treeline::localizer {

// The covariance of errors that are `factor` times as large.
geometry::PoseCovariance Widened(const geometry::PoseCovariance& covariance,
                                 double factor);

// Of two errors that know nothing of each other.
geometry::PoseCovariance Sum(const geometry::PoseCovariance& a,
                             const geometry::PoseCovariance& b);

// The probability that a normal error of the position with this covariance is
// within kApart_m along the axis that is known least:
//   erf(kApart_m / (sqrt(2) sigma)),
// where sigma^2 is the largest eigenvalue of the position's block. In [0, 1]; 0
// for what is not finite.
double ProbabilityNear(const geometry::PoseCovariance& covariance);

// Tells an answer without depth how well its position is known at all. By what
// matched features alone say of it (`of_features`, see Verdict) and what not to
// know the camera adds (`camera`, `scale` times as wide; nullopt: nothing tells
// of the camera) its confidence becomes as much smaller as ProbabilityNear
// says, and below `min_confidence` it is no answer. Its covariance, which is
// narrower than that of the features, gets `scale` times as wide, and that of
// the camera is added. Without features only the latter.
void WeighDoubt(const std::optional<geometry::PoseCovariance>& of_features,
                const std::optional<geometry::PoseCovariance>& camera,
                double scale, double min_confidence, PoseEstimate& estimate);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_POSITION_DOUBT_H_
