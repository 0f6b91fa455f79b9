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

namespace treeline {
namespace {

Time_ns ToNanoseconds(double time_s) {
  return static_cast<Time_ns>(std::llround(1e9 * time_s));
}

std::optional<Rigid3> ReferenceAt(std::span<const TimedPose> reference,
                                  Time_ns time,
                                  const TrajectoryScoreOptions& options) {
  if (const std::optional<Rigid3> pose =
          InterpolatePose(reference, time, ToNanoseconds(options.max_gap_s))) {
    return pose;
  }
  const auto after = std::lower_bound(
      reference.begin(), reference.end(), time,
      [](const TimedPose& pose, Time_ns at) { return pose.time < at; });
  const Time_ns limit = ToNanoseconds(options.max_difference_s);
  std::optional<Rigid3> nearest;
  Time_ns least = limit;
  const auto consider = [&](const TimedPose& pose) {
    const Time_ns difference = std::abs(pose.time - time);
    if (difference > least) return;
    least = difference;
    nearest = pose.world_from_camera;
  };
  if (after != reference.end()) consider(*after);
  if (after != reference.begin()) consider(*std::prev(after));
  return nearest;
}

struct PosePair {
  Time_ns time = 0;
  Rigid3 estimate;
  Rigid3 reference;
};

void ScoreRelative(const std::vector<PosePair>& pairs,
                   const TrajectoryScoreOptions& options,
                   TrajectoryScore& result) {
  const Time_ns interval = ToNanoseconds(options.interval_s);
  std::vector<double> distances_m;
  std::vector<double> angles_rad;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const Time_ns wanted = pairs[i].time + interval;
    auto next = std::lower_bound(
        pairs.begin() + static_cast<std::ptrdiff_t>(i) + 1, pairs.end(), wanted,
        [](const PosePair& pair, Time_ns at) { return pair.time < at; });
    if (next == pairs.end() ||
        (next != pairs.begin() + static_cast<std::ptrdiff_t>(i) + 1 &&
         wanted - std::prev(next)->time < next->time - wanted)) {
      if (next == pairs.begin() + static_cast<std::ptrdiff_t>(i) + 1) break;
      --next;
    }
    if (std::abs(next->time - wanted) >= interval / 10) continue;
    const Rigid3 moved = pairs[i].estimate.Inverse() * next->estimate;
    const Rigid3 truly = pairs[i].reference.Inverse() * next->reference;
    const Rigid3 error = truly.Inverse() * moved;
    distances_m.push_back(Norm(error.translation));
    angles_rad.push_back(AngleBetween_rad(error.rotation, {}));
  }
  result.pairs = static_cast<int>(distances_m.size());
  result.relative_m = Summarize(std::move(distances_m));
  result.relative_rad = Summarize(std::move(angles_rad));
}

}  // namespace

absl::Status TrajectoryScoreOptions::Validate() const {
  TL_RETURN_IF_ERROR(CheckRange("max_gap_s", max_gap_s, 0, 1e6));
  TL_RETURN_IF_ERROR(CheckRange("max_difference_s", max_difference_s, 0, 1e6));
  return CheckRange("interval_s", interval_s, 1e-6, 1e6);
}

absl::StatusOr<TrajectoryScore> ScoreTrajectory(
    std::span<const TimedPose> estimate, std::span<const TimedPose> reference,
    const TrajectoryScoreOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  std::vector<PosePair> pairs;
  Kabsch kabsch;
  for (const TimedPose& pose : estimate) {
    const std::optional<Rigid3> there =
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
  if (const std::optional<Rigid3> aligned = kabsch.Solve()) {
    result.reference_from_estimate = *aligned;
  } else {
    // On one line, positions leave a turn about it open: that of the first.
    result.reference_from_estimate =
        pairs.front().reference * pairs.front().estimate.Inverse();
  }
  std::vector<double> distances_m;
  std::vector<double> angles_rad;
  for (const PosePair& pair : pairs) {
    const Rigid3 aligned = result.reference_from_estimate * pair.estimate;
    distances_m.push_back(
        Norm(aligned.translation - pair.reference.translation));
    angles_rad.push_back(
        AngleBetween_rad(aligned.rotation, pair.reference.rotation));
  }
  result.absolute_m = Summarize(std::move(distances_m));
  result.absolute_rad = Summarize(std::move(angles_rad));
  ScoreRelative(pairs, options, result);
  return result;
}

}  // namespace treeline
