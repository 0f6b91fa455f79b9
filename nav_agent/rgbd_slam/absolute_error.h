// How far a trajectory is from a reference, as the TUM RGB-D benchmark has it
// (Sturm et al., "A Benchmark for the Evaluation of RGB-D SLAM Systems", IROS
// 2012).
#ifndef NAV_AGENT_RGBD_SLAM_ABSOLUTE_ERROR_H_
#define NAV_AGENT_RGBD_SLAM_ABSOLUTE_ERROR_H_

#include <span>

#include "absl/status/statusor.h"
#include "common/base/sample_statistics.h"
#include "common/dataset/text_formats.h"

namespace treeline::rgbd_slam {

struct TrajectoryScoreOptions {
  // The reference is interpolated at the times of the estimate, between poses
  // that are at most this far apart (s), in [0, 1e6]; an estimate nearer than
  // max_difference_s to a pose takes it even where it cannot be interpolated.
  double max_gap_s = 0.1;
  double max_difference_s = 0.02;
  // Relative errors are over so much time (s), in (0, 1e6].
  double interval_s = 1;

  absl::Status Validate() const;
};

struct TrajectoryScore {
  // Poses of the estimate, and those with a reference.
  int poses = 0;
  int associated = 0;
  // Takes the estimate onto the reference: rigid, without scale (Umeyama
  // 1991).
  geometry::Rigid3 reference_from_estimate;
  // Absolute trajectory error: distances of the aligned positions, and angles
  // of the aligned rotations.
  base::ErrorSummary absolute_m;
  base::ErrorSummary absolute_rad;
  // Relative pose error: of motions over interval_s (pairs of associated poses
  // whose times are that far apart to within less than a tenth of it).
  int pairs = 0;
  base::ErrorSummary relative_m;
  base::ErrorSummary relative_rad;
};

// Both in order of time. INVALID_ARGUMENT if fewer than three poses of the
// estimate have a reference.
absl::StatusOr<TrajectoryScore> ScoreTrajectory(
    std::span<const dataset::TimedPose> estimate,
    std::span<const dataset::TimedPose> reference,
    const TrajectoryScoreOptions& options = {});

}  // namespace treeline::rgbd_slam

#endif  // NAV_AGENT_RGBD_SLAM_ABSOLUTE_ERROR_H_
