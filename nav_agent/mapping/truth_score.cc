#include "nav_agent/mapping/truth_score.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "common/dataset/tum.h"

namespace treeline::mapping {
namespace {

constexpr dataset::Time_ns kMaxGap = 100'000'000;

struct Pair {
  geometry::Rigid3 estimated;
  geometry::Rigid3 truth;
};

double HeadingOf(const geometry::Rotation3& rotation) {
  const geometry::Vec3 ahead = rotation * geometry::Vec3{1, 0, 0};
  return std::atan2(ahead.y, ahead.x);
}

// By a turn about z that leaves the point `from` at `to`.
geometry::Rigid3 TurnedAbout(double yaw_rad, geometry::Vec3 from,
                             geometry::Vec3 to) {
  const geometry::Rotation3 turn =
      geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad});
  return {.rotation = turn, .translation = to - turn * from};
}

geometry::Rigid3 AlignRigidly(const std::vector<Pair>& pairs) {
  geometry::Vec3 estimated_mean;
  geometry::Vec3 true_mean;
  const double part = 1.0 / static_cast<double>(pairs.size());
  for (const Pair& pair : pairs) {
    estimated_mean = estimated_mean + part * pair.estimated.translation;
    true_mean = true_mean + part * pair.truth.translation;
  }
  double sine = 0;
  double cosine = 0;
  for (const Pair& pair : pairs) {
    const geometry::Vec3 a = pair.estimated.translation - estimated_mean;
    const geometry::Vec3 b = pair.truth.translation - true_mean;
    cosine += a.x * b.x + a.y * b.y;
    sine += a.x * b.y - a.y * b.x;
  }
  return TurnedAbout(std::atan2(sine, cosine), estimated_mean, true_mean);
}

}  // namespace

absl::StatusOr<TruthScore> ScoreAgainstTruth(
    std::span<const dataset::TimedPose> estimate,
    std::span<const dataset::TimedPose> truth, TruthAlignment alignment) {
  std::vector<Pair> pairs;
  for (const dataset::TimedPose& pose : estimate) {
    const std::optional<geometry::Rigid3> true_pose =
        dataset::InterpolatePose(truth, pose.time, kMaxGap);
    if (!true_pose.has_value()) continue;
    pairs.push_back({.estimated = pose.world_from_camera, .truth = *true_pose});
  }
  if (pairs.empty()) {
    return absl::InvalidArgumentError("the truth covers no pose");
  }
  const Pair& first = pairs.front();
  const geometry::Rigid3 true_from_estimated =
      alignment == TruthAlignment::kRigid
          ? AlignRigidly(pairs)
          : TurnedAbout(HeadingOf(first.truth.rotation) -
                            HeadingOf(first.estimated.rotation),
                        first.estimated.translation, first.truth.translation);
  TruthScore score;
  score.poses = static_cast<int64_t>(pairs.size());
  double planar = 0;
  double height = 0;
  double rotation = 0;
  for (const Pair& pair : pairs) {
    const geometry::Rigid3 aligned = true_from_estimated * pair.estimated;
    const geometry::Vec3 off = aligned.translation - pair.truth.translation;
    const double planar2 = off.x * off.x + off.y * off.y;
    planar += planar2;
    height += off.z * off.z;
    score.max_m = std::max(score.max_m, std::sqrt(planar2 + off.z * off.z));
    const double angle_rad =
        geometry::AngleBetween_rad(aligned.rotation, pair.truth.rotation);
    rotation += angle_rad * angle_rad;
  }
  const auto count = static_cast<double>(pairs.size());
  score.rmse_m = std::sqrt((planar + height) / count);
  score.planar_rmse_m = std::sqrt(planar / count);
  score.height_rmse_m = std::sqrt(height / count);
  score.rotation_rmse_rad = std::sqrt(rotation / count);
  return score;
}

}  // namespace treeline::mapping
