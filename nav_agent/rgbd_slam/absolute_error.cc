#include "nav_agent/rgbd_slam/absolute_error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "common/dataset/tum.h"
#include "common/geometry/kabsch.h"

namespace treeline::rgbd_slam {
namespace {

dataset::Time_ns ToNanoseconds(double time_s) {
  return static_cast<dataset::Time_ns>(std::llround(1e9 * time_s));
}

std::optional<geometry::Rigid3> ReferenceAt(
    std::span<const dataset::TimedPose> reference, dataset::Time_ns time,
    const TrajectoryScoreOptions& options) {
  if (const std::optional<geometry::Rigid3> pose = dataset::InterpolatePose(
          reference, time, ToNanoseconds(options.max_gap_s))) {
    return pose;
  }
  const auto after =
      std::lower_bound(reference.begin(), reference.end(), time,
                       [](const dataset::TimedPose& pose, dataset::Time_ns at) {
                         return pose.time < at;
                       });
  const dataset::Time_ns limit = ToNanoseconds(options.max_difference_s);
  std::optional<geometry::Rigid3> nearest;
  dataset::Time_ns least = limit;
  const auto consider = [&](const dataset::TimedPose& pose) {
    const dataset::Time_ns difference = std::abs(pose.time - time);
    if (difference > least) return;
    least = difference;
    nearest = pose.world_from_camera;
  };
  if (after != reference.end()) consider(*after);
  if (after != reference.begin()) consider(*std::prev(after));
  return nearest;
}

struct PosePair {
  dataset::Time_ns time = 0;
  geometry::Rigid3 estimate;
  geometry::Rigid3 reference;
};

void ScoreRelative(const std::vector<PosePair>& pairs,
                   const TrajectoryScoreOptions& options,
                   TrajectoryScore& result) {
  const dataset::Time_ns interval = ToNanoseconds(options.interval_s);
  std::vector<double> distances_m;
  std::vector<double> angles_rad;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const dataset::Time_ns wanted = pairs[i].time + interval;
    auto next = std::lower_bound(
        pairs.begin() + static_cast<std::ptrdiff_t>(i) + 1, pairs.end(), wanted,
        [](const PosePair& pair, dataset::Time_ns at) {
          return pair.time < at;
        });
    if (next == pairs.end() ||
        (next != pairs.begin() + static_cast<std::ptrdiff_t>(i) + 1 &&
         wanted - std::prev(next)->time < next->time - wanted)) {
      if (next == pairs.begin() + static_cast<std::ptrdiff_t>(i) + 1) break;
      --next;
    }
    if (std::abs(next->time - wanted) >= interval / 10) continue;
    const geometry::Rigid3 moved = pairs[i].estimate.Inverse() * next->estimate;
    const geometry::Rigid3 truly =
        pairs[i].reference.Inverse() * next->reference;
    const geometry::Rigid3 error = truly.Inverse() * moved;
    distances_m.push_back(geometry::Norm(error.translation));
    angles_rad.push_back(geometry::AngleBetween_rad(error.rotation, {}));
  }
  result.pairs = static_cast<int>(distances_m.size());
  result.relative_m = base::Summarize(std::move(distances_m));
  result.relative_rad = base::Summarize(std::move(angles_rad));
}

}  // namespace

absl::Status TrajectoryScoreOptions::Validate() const {
  TL_RETURN_IF_ERROR(base::CheckRange("max_gap_s", max_gap_s, 0, 1e6));
  TL_RETURN_IF_ERROR(
      base::CheckRange("max_difference_s", max_difference_s, 0, 1e6));
  return base::CheckRange("interval_s", interval_s, 1e-6, 1e6);
}

absl::StatusOr<TrajectoryScore> ScoreTrajectory(
    std::span<const dataset::TimedPose> estimate,
    std::span<const dataset::TimedPose> reference,
    const TrajectoryScoreOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  std::vector<PosePair> pairs;
  geometry::Kabsch kabsch;
  for (const dataset::TimedPose& pose : estimate) {
    const std::optional<geometry::Rigid3> there =
        ReferenceAt(reference, pose.time, options);
    if (!there) continue;
    pairs.push_back({pose.time, pose.world_from_camera, *there});
    kabsch.Add(there->translation, pose.world_from_camera.translation);
  }
  if (pairs.size() < 3) {
    return absl::InvalidArgumentError(
        absl::StrCat(pairs.size(), " of ", estimate.size(),
                     " poses have a reference; it takes at least 3"));
  }
  TrajectoryScore result;
  result.poses = static_cast<int>(estimate.size());
  result.associated = static_cast<int>(pairs.size());
  if (const std::optional<geometry::Rigid3> aligned = kabsch.Solve()) {
    result.reference_from_estimate = *aligned;
  } else {
    // On one line, positions leave a turn about it open: that of the first.
    result.reference_from_estimate =
        pairs.front().reference * pairs.front().estimate.Inverse();
  }
  std::vector<double> distances_m;
  std::vector<double> angles_rad;
  for (const PosePair& pair : pairs) {
    const geometry::Rigid3 aligned =
        result.reference_from_estimate * pair.estimate;
    distances_m.push_back(
        geometry::Norm(aligned.translation - pair.reference.translation));
    angles_rad.push_back(
        geometry::AngleBetween_rad(aligned.rotation, pair.reference.rotation));
  }
  result.absolute_m = base::Summarize(std::move(distances_m));
  result.absolute_rad = base::Summarize(std::move(angles_rad));
  ScoreRelative(pairs, options, result);
  return result;
}

}  // namespace treeline::rgbd_slam
