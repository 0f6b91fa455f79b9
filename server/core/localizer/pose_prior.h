// What a client knows about its pose before it asks, against what was found.
#ifndef SERVER_CORE_LOCALIZER_POSE_PRIOR_H_
#define SERVER_CORE_LOCALIZER_POSE_PRIOR_H_

#include "common/geometry/pose_prior.h"
#include "server/core/localizer/localizer.h"

namespace treeline::localizer {

// Withdraws a pose that a prior rules out: it becomes kNotLocalized with reason
// kContradictsPrior; its evidence stays. A prior never makes a pose more
// probable, so that a wrong one can hide an answer but not forge one.
void ApplyPriors(const geometry::PosePriors& priors, PoseEstimate& estimate);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_POSE_PRIOR_H_
