#include "evaluation/accuracy/training_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>

namespace treeline::accuracy {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;

// Where bins end; the last one has no end.
constexpr std::array kDistanceEnds_m{0.1, 0.2, 0.3, 0.5, 1.0};
constexpr std::array kAngleEnds_deg{5.0, 10.0, 15.0, 30.0, 60.0};
constexpr std::array kViewGapEnds{0.5, 1.0, 2.0, 4.0};

std::vector<TrainingDistanceBin> Binned(const EvaluatedMethod& method,
                                        const PoseThreshold& right_within,
                                        double confidence_threshold,
                                        std::span<const double> values,
                                        std::span<const double> ends) {
  std::vector<TrainingDistanceBin> bins;
  for (size_t b = 0; b <= ends.size(); ++b) {
    TrainingDistanceBin& bin = bins.emplace_back();
    if (b > 0) bin.low = ends[b - 1];
    if (b < ends.size()) bin.high = ends[b];
    std::vector<FrameResult> inside;
    for (size_t i = 0; i < values.size(); ++i) {
      // Frames without truth have none, and compare false.
      if (values[i] >= bin.low && (!bin.high || values[i] < *bin.high)) {
        inside.push_back(method.results[i]);
      }
    }
    bin.counts = CountAnswers(inside, right_within, confidence_threshold);
  }
  return bins;
}

double MetresPerUnit(const forest::ModelInfo& model) {
  if (model.units_are_metres || !(model.viewing_distance > 0)) return 1;
  return kViewDistance_m / model.viewing_distance;
}

// With lengths in metres, or what stands for them.
geometry::Rigid3 InMetres(geometry::Rigid3 pose, double metres_per_unit) {
  pose.translation = metres_per_unit * pose.translation;
  return pose;
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

double ViewGap(const geometry::Rigid3& a, const geometry::Rigid3& b,
               const ViewLimits& near) {
  const geometry::PoseError error = geometry::ErrorBetween(a, b);
  return std::max(error.translation_m / near.translation_m,
                  error.rotation_rad * kDegreesPerRadian / near.rotation_deg);
}

double ViewGap(const geometry::Rigid3& world_from_camera,
               const std::vector<geometry::Rigid3>& training_poses,
               const ViewLimits& near) {
  double least = std::numeric_limits<double>::infinity();
  for (const geometry::Rigid3& pose : training_poses) {
    least = std::min(least, ViewGap(world_from_camera, pose, near));
  }
  return least;
}

TrainingDistanceBins BinByTrainingDistance(const EvaluatedMethod& method,
                                           double confidence_threshold) {
  const double metres = MetresPerUnit(method.model);
  std::vector<geometry::Rigid3> training_poses;
  for (const geometry::Rigid3& pose : method.training_poses) {
    training_poses.push_back(InMetres(pose, metres));
  }
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> distances_m(method.results.size(), kUnknown);
  std::vector<double> angles_deg = distances_m;
  std::vector<double> gaps = distances_m;
  bool any = false;
  for (size_t i = 0; i < method.results.size(); ++i) {
    const auto& truth = method.results[i].true_world_from_camera;
    if (!truth || training_poses.empty()) continue;
    any = true;
    const geometry::Rigid3 pose = InMetres(*truth, metres);
    const TrainingDistance nearest = *DistanceToTraining(pose, training_poses);
    distances_m[i] = nearest.translation_m;
    angles_deg[i] = nearest.rotation_deg;
    gaps[i] = ViewGap(pose, training_poses, ViewLimits{});
  }
  if (!any) return {};
  const PoseThreshold right_within =
      RightWithin(method.results, method.model.units_are_metres);
  const auto binned = [&](std::span<const double> values,
                          std::span<const double> ends) {
    return Binned(method, right_within, confidence_threshold, values, ends);
  };
  return {.by_distance_m = binned(distances_m, kDistanceEnds_m),
          .by_angle_deg = binned(angles_deg, kAngleEnds_deg),
          .by_view_gap = binned(gaps, kViewGapEnds)};
}

}  // namespace treeline::accuracy
