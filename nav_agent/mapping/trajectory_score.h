// How good a trajectory is.
#ifndef NAV_AGENT_MAPPING_TRAJECTORY_SCORE_H_
#define NAV_AGENT_MAPPING_TRAJECTORY_SCORE_H_

#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "common/base/sample_statistics.h"
#include "nav_agent/mapping/trajectory_pose.h"
#include "nav_agent/recording/relations.h"

namespace treeline::mapping {

struct RelationScoreOptions {
  // Poses between two of the trajectory are interpolated. Relations of which a
  // time is farther than this from the nearer of the two (s, 0 or more), or
  // where the two are farther apart than max_step (m, rad), are left out.
  double max_gap_s = 1e9;
  double max_step_m = 1e9;
  double max_step_rad = 1e9;
};

struct RelationScore {
  int used = 0;
  int left_out = 0;
  base::ErrorSummary translation_m;
  base::ErrorSummary rotation_rad;
};

// The pose at `time`, interpolated between its neighbours in `trajectory`
// (ordered by time); nothing outside of it, or of the options' limits.
std::optional<geometry::Rigid2> PoseAt(
    std::span<const TrajectoryPose> trajectory, recording::RecordingTime time,
    const RelationScoreOptions& options = {});

// The SLAM benchmarking metric (Kuemmerle et al., "On Measuring the Accuracy of
// SLAM Algorithms", Autonomous Robots 27, 2009): over reference relations d*
// and those of the trajectory d, the error d*^-1 d, its translation and its
// rotation apart. It does not ask for a common frame, nor grow with where in
// the run an error was made. INVALID_ARGUMENT if no relation can be used.
absl::StatusOr<RelationScore> ScoreRelations(
    std::span<const TrajectoryPose> trajectory,
    std::span<const recording::PoseRelation> relations,
    const RelationScoreOptions& options = {});

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_TRAJECTORY_SCORE_H_
