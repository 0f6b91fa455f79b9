#include "evaluation/accuracy/training_distance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace treeline::accuracy {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;
constexpr size_t kGroups = 5;

struct FrameAtDistance {
  double distance_m = 0;
  const FrameResult* result = nullptr;
};

// Scored frames, nearest to a training camera first.
std::vector<FrameAtDistance> ByDistance(
    const std::vector<FrameResult>& results,
    const std::vector<geometry::Rigid3>& training_poses) {
  std::vector<FrameAtDistance> frames;
  for (const FrameResult& result : results) {
    if (!result.true_world_from_camera) continue;
    const auto nearest =
        DistanceToTraining(*result.true_world_from_camera, training_poses);
    if (nearest) frames.push_back({nearest->combined_m, &result});
  }
  std::ranges::stable_sort(frames, {}, &FrameAtDistance::distance_m);
  return frames;
}

}  // namespace

std::optional<TrainingDistance> DistanceToTraining(
    const geometry::Rigid3& world_from_camera,
    const std::vector<geometry::Rigid3>& training_poses) {
  std::optional<TrainingDistance> nearest;
  for (const geometry::Rigid3& pose : training_poses) {
    const geometry::PoseError error =
        geometry::ErrorBetween(world_from_camera, pose);
    const double combined_m =
        std::hypot(error.translation_m, kViewDistance_m * error.rotation_rad);
    if (nearest && nearest->combined_m <= combined_m) continue;
    nearest = {error.translation_m, error.rotation_rad * kDegreesPerRadian,
               combined_m};
  }
  return nearest;
}

std::vector<DistanceGroup> GroupByTrainingDistance(
    const std::vector<FrameResult>& results,
    const std::vector<geometry::Rigid3>& training_poses) {
  const std::vector<FrameAtDistance> frames =
      ByDistance(results, training_poses);
  const size_t count = std::min(kGroups, frames.size());
  std::vector<DistanceGroup> groups;
  for (size_t g = 0; g < count; ++g) {
    const size_t begin = g * frames.size() / count;
    const size_t end = (g + 1) * frames.size() / count;
    DistanceGroup group;
    group.frames = static_cast<int>(end - begin);
    int correct = 0;
    std::vector<double> errors_m;
    for (size_t i = begin; i < end; ++i) {
      const FrameResult& result = *frames[i].result;
      group.distance_m += frames[i].distance_m / group.frames;
      correct += IsWithin(result, PoseThreshold{});
      if (result.error) errors_m.push_back(result.error->translation_m);
    }
    group.correct = static_cast<double>(correct) / group.frames;
    group.median_translation_m = Percentile(std::move(errors_m), 50);
    groups.push_back(group);
  }
  return groups;
}

}  // namespace treeline::accuracy
