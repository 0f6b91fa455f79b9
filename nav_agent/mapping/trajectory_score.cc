#include "nav_agent/mapping/trajectory_score.h"

#include <algorithm>
#include <cmath>

namespace treeline::mapping {

std::optional<geometry::Rigid2> PoseAt(
    std::span<const TrajectoryPose> trajectory, recording::RecordingTime time,
    const RelationScoreOptions& options) {
  // A microsecond: how stamps are rounded in files.
  constexpr double kSame_s = 1.5e-6;
  const auto after = std::lower_bound(
      trajectory.begin(), trajectory.end(), time,
      [](const TrajectoryPose& pose, recording::RecordingTime t) {
        return pose.stamp < t;
      });
  if (after != trajectory.end() &&
      recording::SecondsBetween(time, after->stamp) <= kSame_s) {
    return after->map_from_base;
  }
  if (after == trajectory.begin()) return std::nullopt;
  const auto before = after - 1;
  const double since_s = recording::SecondsBetween(before->stamp, time);
  if (since_s <= kSame_s) return before->map_from_base;
  if (after == trajectory.end()) return std::nullopt;
  const double until_s = recording::SecondsBetween(time, after->stamp);
  const geometry::Rigid2 step =
      before->map_from_base.Inverse() * after->map_from_base;
  if (std::min(since_s, until_s) > options.max_gap_s ||
      geometry::Norm(step.translation) > options.max_step_m ||
      std::abs(step.yaw_rad) > options.max_step_rad) {
    return std::nullopt;
  }
  const double part = since_s / (since_s + until_s);
  return before->map_from_base *
         geometry::Rigid2{part * step.translation, part * step.yaw_rad};
}

absl::StatusOr<RelationScore> ScoreRelations(
    std::span<const TrajectoryPose> trajectory,
    std::span<const recording::PoseRelation> relations,
    const RelationScoreOptions& options) {
  std::vector<double> translation_m;
  std::vector<double> rotation_rad;
  for (const recording::PoseRelation& relation : relations) {
    const auto from = PoseAt(trajectory, relation.from, options);
    const auto to = PoseAt(trajectory, relation.to, options);
    if (!from.has_value() || !to.has_value()) continue;
    const geometry::Rigid2 error =
        relation.from_base_from_to_base.Inverse() * (from->Inverse() * *to);
    translation_m.push_back(geometry::Norm(error.translation));
    rotation_rad.push_back(
        std::abs(geometry::NormalizedAngle_rad(error.yaw_rad)));
  }
  if (translation_m.empty()) {
    return absl::InvalidArgumentError(
        "no relation lies within the trajectory's time");
  }
  return RelationScore{
      .used = static_cast<int>(translation_m.size()),
      .left_out = static_cast<int>(relations.size() - translation_m.size()),
      .translation_m = base::Summarize(std::move(translation_m)),
      .rotation_rad = base::Summarize(std::move(rotation_rad))};
}

}  // namespace treeline::mapping
