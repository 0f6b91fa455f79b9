#include "common/dataset/trajectory_error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "common/dataset/tum.h"
#include "common/geometry/kabsch.h"
#include "common/geometry/planar_pose.h"

namespace treeline::dataset {
namespace {

Time_ns ToNanoseconds(double time_s) {
  return static_cast<Time_ns>(std::llround(1e9 * time_s));
}

struct Means {
  geometry::Vec3 estimate;
  geometry::Vec3 reference;
};

Means MeanPositions(std::span<const PosePair> pairs) {
  Means means;
  const auto count = static_cast<double>(pairs.size());
  for (const PosePair& pair : pairs) {
    means.estimate = means.estimate + pair.estimate.translation / count;
    means.reference = means.reference + pair.reference.translation / count;
  }
  return means;
}

// By a turn about z that leaves the point `from` at `to`.
geometry::Rigid3 TurnedAbout(double yaw_rad, geometry::Vec3 from,
                             geometry::Vec3 to) {
  const geometry::Rotation3 turn =
      geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad});
  return {.rotation = turn, .translation = to - turn * from};
}

geometry::Rigid3 AlignUpright(std::span<const PosePair> pairs) {
  const Means means = MeanPositions(pairs);
  double sine = 0;
  double cosine = 0;
  for (const PosePair& pair : pairs) {
    const geometry::Vec3 a = pair.estimate.translation - means.estimate;
    const geometry::Vec3 b = pair.reference.translation - means.reference;
    cosine += a.x * b.x + a.y * b.y;
    sine += a.x * b.y - a.y * b.x;
  }
  return TurnedAbout(std::atan2(sine, cosine), means.estimate, means.reference);
}

std::optional<geometry::Rigid3> AlignRigidly(std::span<const PosePair> pairs) {
  geometry::Kabsch kabsch;
  for (const PosePair& pair : pairs) {
    kabsch.Add(pair.reference.translation, pair.estimate.translation);
  }
  return kabsch.Solve();
}

// The scale of least squares once positions are rotated: both sets about their
// means, of which one is then taken onto the other.
FrameAlignment WithScale(std::span<const PosePair> pairs,
                         const geometry::Rotation3& rotation) {
  const Means means = MeanPositions(pairs);
  double products = 0;
  double squares = 0;
  for (const PosePair& pair : pairs) {
    const geometry::Vec3 turned =
        rotation * (pair.estimate.translation - means.estimate);
    products +=
        geometry::Dot(turned, pair.reference.translation - means.reference);
    squares += geometry::SquaredNorm(turned);
  }
  const double scale = products / squares;
  return {.reference_from_estimate = {.rotation = rotation,
                                      .translation =
                                          means.reference -
                                          scale * (rotation * means.estimate)},
          .scale = scale};
}

bool TurnsInSpace(TrajectoryAlignment alignment) {
  return alignment == TrajectoryAlignment::kRigid ||
         alignment == TrajectoryAlignment::kSimilarity;
}

std::optional<geometry::Rigid3> ReferenceAt(
    std::span<const TimedPose> reference, Time_ns time,
    const TrajectoryScoreOptions& options) {
  if (const std::optional<geometry::Rigid3> pose =
          InterpolatePose(reference, time, ToNanoseconds(options.max_gap_s))) {
    return pose;
  }
  const auto after = std::lower_bound(
      reference.begin(), reference.end(), time,
      [](const TimedPose& pose, Time_ns at) { return pose.time < at; });
  std::optional<geometry::Rigid3> nearest;
  Time_ns least = ToNanoseconds(options.max_difference_s);
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

std::optional<FrameAlignment> AlignTrajectory(std::span<const PosePair> pairs,
                                              TrajectoryAlignment alignment) {
  if (pairs.empty()) return std::nullopt;
  const PosePair& first = pairs.front();
  switch (alignment) {
    case TrajectoryAlignment::kNone:
      return FrameAlignment{};
    case TrajectoryAlignment::kFirstPoseUpright:
      return FrameAlignment{
          TurnedAbout(geometry::Yaw_rad(first.reference.rotation) -
                          geometry::Yaw_rad(first.estimate.rotation),
                      first.estimate.translation, first.reference.translation)};
    case TrajectoryAlignment::kUpright:
      return FrameAlignment{AlignUpright(pairs)};
    case TrajectoryAlignment::kRigid:
    case TrajectoryAlignment::kSimilarity:
      break;
  }
  const std::optional<geometry::Rigid3> rigid = AlignRigidly(pairs);
  if (!rigid) return std::nullopt;
  if (alignment == TrajectoryAlignment::kRigid) return FrameAlignment{*rigid};
  return WithScale(pairs, rigid->rotation);
}

TrajectoryError ErrorOf(std::span<const PosePair> pairs,
                        const FrameAlignment& alignment) {
  const geometry::Rigid3& aligned = alignment.reference_from_estimate;
  std::vector<double> positions_m;
  std::vector<double> planar_m;
  std::vector<double> heights_m;
  std::vector<double> rotations_rad;
  for (const PosePair& pair : pairs) {
    const geometry::Vec3 off =
        alignment.scale * (aligned.rotation * pair.estimate.translation) +
        aligned.translation - pair.reference.translation;
    positions_m.push_back(geometry::Norm(off));
    planar_m.push_back(std::hypot(off.x, off.y));
    heights_m.push_back(std::abs(off.z));
    rotations_rad.push_back(geometry::AngleBetween_rad(
        aligned.rotation * pair.estimate.rotation, pair.reference.rotation));
  }
  return {.poses = static_cast<int>(pairs.size()),
          .alignment = alignment,
          .position_m = base::Summarize(std::move(positions_m)),
          .planar_m = base::Summarize(std::move(planar_m)),
          .height_m = base::Summarize(std::move(heights_m)),
          .rotation_rad = base::Summarize(std::move(rotations_rad))};
}

std::optional<TrajectoryError> AbsoluteTrajectoryError(
    std::span<const PosePair> pairs, TrajectoryAlignment alignment) {
  const std::optional<FrameAlignment> aligned =
      AlignTrajectory(pairs, alignment);
  if (!aligned) return std::nullopt;
  return ErrorOf(pairs, *aligned);
}

absl::Status TrajectoryScoreOptions::Validate() const {
  TL_RETURN_IF_ERROR(base::CheckRange("max_gap_s", max_gap_s, 0, 1e6));
  TL_RETURN_IF_ERROR(
      base::CheckRange("max_difference_s", max_difference_s, 0, 1e6));
  return base::CheckRange("interval_s", interval_s, 1e-6, 1e6);
}

std::vector<PosePair> PairByTime(std::span<const TimedPose> estimate,
                                 std::span<const TimedPose> reference,
                                 const TrajectoryScoreOptions& options) {
  std::vector<PosePair> pairs;
  for (const TimedPose& pose : estimate) {
    const std::optional<geometry::Rigid3> there =
        ReferenceAt(reference, pose.time, options);
    if (there) pairs.push_back({pose.time, pose.world_from_camera, *there});
  }
  return pairs;
}

absl::StatusOr<TrajectoryScore> ScoreTrajectory(
    std::span<const TimedPose> estimate, std::span<const TimedPose> reference,
    const TrajectoryScoreOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  const std::vector<PosePair> pairs = PairByTime(estimate, reference, options);
  const size_t needed = TurnsInSpace(options.alignment) ? 3 : 1;
  if (pairs.size() < needed) {
    return absl::InvalidArgumentError(
        absl::StrCat(pairs.size(), " of ", estimate.size(),
                     " poses have a reference; it takes at least ", needed));
  }
  // On one line, positions leave a turn about it open: that of the first.
  const FrameAlignment first{pairs.front().reference *
                             pairs.front().estimate.Inverse()};
  TrajectoryScore result;
  result.poses = static_cast<int>(estimate.size());
  result.absolute =
      ErrorOf(pairs, AlignTrajectory(pairs, options.alignment).value_or(first));
  ScoreRelative(pairs, options, result);
  return result;
}

}  // namespace treeline::dataset
