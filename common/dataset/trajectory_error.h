// How far a trajectory is from a reference: absolute and relative errors (Sturm
// et al., "A Benchmark for the Evaluation of RGB-D SLAM Systems", IROS 2012).
#ifndef COMMON_DATASET_TRAJECTORY_ERROR_H_
#define COMMON_DATASET_TRAJECTORY_ERROR_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/sample_statistics.h"
#include "common/dataset/text_formats.h"

namespace treeline::dataset {

// The pose of an estimate, and that of the reference at the same time: from the
// camera (or whatever moves) to the frames of the two.
struct PosePair {
  Time_ns time = 0;
  geometry::Rigid3 estimate;
  geometry::Rigid3 reference;
};

// How the estimate's frame is laid upon the reference's before errors are
// taken.
enum class TrajectoryAlignment : uint8_t {
  // Both are the same frame.
  kNone,
  // By a turn about z, up in both, and a translation that make the first pose
  // right: errors are how far the estimate drifts from there.
  kFirstPoseUpright,
  // By a turn about z and a translation, of least squares of all positions.
  kUpright,
  // By a rotation and a translation, of least squares (Horn 1987).
  kRigid,
  // The same and a scale (Umeyama 1991).
  kSimilarity,
};

// p -> scale * (reference_from_estimate.rotation * p) + translation.
struct FrameAlignment {
  geometry::Rigid3 reference_from_estimate;
  // Lengths of the reference per estimated one. 1 unless kSimilarity.
  double scale = 1;
};

// nullopt: no pair or, where a rotation in space is sought, fewer than three,
// or all positions on one line.
std::optional<FrameAlignment> AlignTrajectory(std::span<const PosePair> pairs,
                                              TrajectoryAlignment alignment);

// The absolute trajectory error (ATE): over all pairs, once aligned.
struct TrajectoryError {
  int poses = 0;
  FrameAlignment alignment;
  // Distances of the positions (units of the reference: metres, but for a
  // structure from motion); the same along x and y alone, and along z alone.
  base::ErrorSummary position_m;
  base::ErrorSummary planar_m;
  base::ErrorSummary height_m;
  // Angles between the rotations.
  base::ErrorSummary rotation_rad;
};

TrajectoryError ErrorOf(std::span<const PosePair> pairs,
                        const FrameAlignment& alignment);

// Aligns, and takes the error. nullopt where there is no alignment.
std::optional<TrajectoryError> AbsoluteTrajectoryError(
    std::span<const PosePair> pairs, TrajectoryAlignment alignment);

struct TrajectoryScoreOptions {
  // The reference is interpolated at the times of the estimate, between poses
  // that are at most this far apart (s), in [0, 1e6]; an estimate nearer than
  // max_difference_s to a pose takes it even where it cannot be interpolated.
  double max_gap_s = 0.1;
  double max_difference_s = 0.02;
  // Relative errors are over so much time (s), in (0, 1e6].
  double interval_s = 1;
  TrajectoryAlignment alignment = TrajectoryAlignment::kRigid;

  absl::Status Validate() const;
};

// Poses of the estimate with those of the reference at their times; what has
// none is left out. Both in order of time.
std::vector<PosePair> PairByTime(std::span<const TimedPose> estimate,
                                 std::span<const TimedPose> reference,
                                 const TrajectoryScoreOptions& options = {});

struct TrajectoryScore {
  // Poses of the estimate; those with a reference are absolute.poses.
  int poses = 0;
  TrajectoryError absolute;
  // Relative pose error: of motions over interval_s (pairs of associated poses
  // whose times are that far apart to within less than a tenth of it).
  int pairs = 0;
  base::ErrorSummary relative_m;
  base::ErrorSummary relative_rad;
};

// Both in order of time. Where kRigid or kSimilarity leave a turn open, since
// all positions lie on one line, the first pose decides. INVALID_ARGUMENT if no
// pose of the estimate has a reference, or fewer than three have where a
// rotation in space is sought.
absl::StatusOr<TrajectoryScore> ScoreTrajectory(
    std::span<const TimedPose> estimate, std::span<const TimedPose> reference,
    const TrajectoryScoreOptions& options = {});

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_TRAJECTORY_ERROR_H_
