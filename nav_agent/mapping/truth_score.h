// How far a trajectory in space is from the true one.
#ifndef NAV_AGENT_MAPPING_TRUTH_SCORE_H_
#define NAV_AGENT_MAPPING_TRUTH_SCORE_H_

#include <cstdint>
#include <span>

#include "absl/status/statusor.h"
#include "common/dataset/text_formats.h"

namespace treeline::mapping {

// Both have z up: they are laid upon each other by a turn about it and a
// translation.
enum class TruthAlignment : uint8_t {
  kFirstPose,  // the first pose is right: errors are how far it drifts from
               // there
  kRigid       // least squares of all positions (absolute trajectory error)
};

struct TruthScore {
  int64_t poses = 0;
  // Root mean squares of the distance in space, seen from above, and in height
  // (m), the largest in space (m), and of the angle between the rotations
  // (rad).
  double rmse_m = 0;
  double planar_rmse_m = 0;
  double height_rmse_m = 0;
  double max_m = 0;
  double rotation_rmse_rad = 0;
};

// Against the truth at the same times, interpolated; poses at times that it
// does not cover to 0.1 s are left out. Both ascend in time. INVALID_ARGUMENT
// if no pose is left.
absl::StatusOr<TruthScore> ScoreAgainstTruth(
    std::span<const dataset::TimedPose> estimate,
    std::span<const dataset::TimedPose> truth, TruthAlignment alignment);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_TRUTH_SCORE_H_
