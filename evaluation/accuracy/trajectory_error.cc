#include "evaluation/accuracy/trajectory_error.h"

#include <cmath>

#include "common/geometry/kabsch.h"

namespace treeline::accuracy {
namespace {

// Where a camera was estimated to be, and where it was (world frame).
struct PositionPair {
  geometry::Vec3 estimated;
  geometry::Vec3 truth;
};

std::vector<PositionPair> PositionPairs(
    const std::vector<FrameResult>& results) {
  std::vector<PositionPair> pairs;
  for (const FrameResult& result : results) {
    if (!result.error) continue;
    pairs.push_back({result.estimate.world_from_camera.translation,
                     result.true_world_from_camera->translation});
  }
  return pairs;
}

// The scale of least squares once positions are rotated: both sets about their
// means.
double BestScale(const std::vector<PositionPair>& pairs,
                 const geometry::Rotation3& rotation) {
  geometry::Vec3 mean_estimated;
  geometry::Vec3 mean_truth;
  const auto count = static_cast<double>(pairs.size());
  for (const PositionPair& pair : pairs) {
    mean_estimated = mean_estimated + pair.estimated / count;
    mean_truth = mean_truth + pair.truth / count;
  }
  double products = 0;
  double squares = 0;
  for (const PositionPair& pair : pairs) {
    const geometry::Vec3 estimated =
        rotation * (pair.estimated - mean_estimated);
    products += geometry::Dot(estimated, pair.truth - mean_truth);
    squares += geometry::SquaredNorm(estimated);
  }
  return products / squares;
}

double MeanSquaredDistance(const std::vector<PositionPair>& pairs, double scale,
                           const geometry::Rotation3& rotation) {
  // The translation of least squares takes mean to mean.
  geometry::Vec3 offset;
  const auto count = static_cast<double>(pairs.size());
  for (const PositionPair& pair : pairs) {
    offset =
        offset + (pair.truth - scale * (rotation * pair.estimated)) / count;
  }
  double sum = 0;
  for (const PositionPair& pair : pairs) {
    sum += geometry::SquaredNorm(scale * (rotation * pair.estimated) + offset -
                                 pair.truth);
  }
  return sum / count;
}

}  // namespace

std::optional<TrajectoryError> AbsoluteTrajectoryError(
    const std::vector<FrameResult>& results, TrajectoryAlignment alignment) {
  const std::vector<PositionPair> pairs = PositionPairs(results);
  if (pairs.empty()) return std::nullopt;
  TrajectoryError error;
  error.poses = static_cast<int>(pairs.size());
  if (alignment == TrajectoryAlignment::kNone) {
    double sum = 0;
    for (const PositionPair& pair : pairs) {
      sum += geometry::SquaredNorm(pair.estimated - pair.truth);
    }
    error.rmse_m = std::sqrt(sum / error.poses);
    return error;
  }
  geometry::Kabsch kabsch;
  for (const PositionPair& pair : pairs) {
    kabsch.Add(pair.truth, pair.estimated);
  }
  const std::optional<geometry::Rigid3> aligned = kabsch.Solve();
  if (!aligned) return std::nullopt;
  if (alignment == TrajectoryAlignment::kSimilarity) {
    error.scale = BestScale(pairs, aligned->rotation);
  }
  error.rmse_m =
      std::sqrt(MeanSquaredDistance(pairs, error.scale, aligned->rotation));
  return error;
}

}  // namespace treeline::accuracy
