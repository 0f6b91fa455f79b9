// How far cameras are from those that a model was trained with, and how
// accuracy falls with it.
#ifndef EVALUATION_ACCURACY_TRAINING_DISTANCE_H_
#define EVALUATION_ACCURACY_TRAINING_DISTANCE_H_

#include <optional>
#include <string>
#include <vector>

#include "common/geometry/rigid3.h"
#include "evaluation/accuracy/answer_counts.h"
#include "evaluation/accuracy/evaluated_method.h"

namespace treeline::accuracy {

// How far a camera is from the nearest one of the training set.
struct TrainingDistance {
  double translation_m = 0;
  double rotation_deg = 0;
  // sqrt(translation^2 + (kViewDistance_m * rotation in rad)^2): roughly how
  // far what the camera sees has moved, at a usual distance.
  double combined_m = 0;
};
inline constexpr double kViewDistance_m = 1.5;

// To the training camera of the least combined distance. nullopt: there is no
// training pose.
std::optional<TrainingDistance> DistanceToTraining(
    const geometry::Rigid3& world_from_camera,
    const std::vector<geometry::Rigid3>& training_poses);

// Views within both of these of each other show about the same.
struct ViewLimits {
  double translation_m = 0.3;
  double rotation_deg = 15;
};

// max(distance / near.translation_m, angle / near.rotation_deg): above 1, the
// views are beyond one of the limits.
double ViewGap(const geometry::Rigid3& a, const geometry::Rigid3& b,
               const ViewLimits& near);

// The least one to a training camera; infinite if there is none.
double ViewGap(const geometry::Rigid3& world_from_camera,
               const std::vector<geometry::Rigid3>& training_poses,
               const ViewLimits& near);

// Frames alike in how far they are from training: [low, high) of `measure`.
struct TrainingDistanceBin {
  double low = 0;
  std::optional<double> high;  // nullopt: no end
  AnswerCounts counts;
};

// The frames of a method by their distance from training. Each list holds every
// scored frame once, near ones first, empty bins included; all are empty if
// there is no training pose or no ground truth.
struct TrainingDistanceBins {
  // Of the training camera of the least combined distance (m; degrees).
  std::vector<TrainingDistanceBin> by_distance_m;
  std::vector<TrainingDistanceBin> by_angle_deg;
  // ViewGap: the first bins are within 0.15 m and 7.5 degrees of a training
  // camera, and within 0.3 m and 15 degrees of one; those from 1 on are beyond.
  std::vector<TrainingDistanceBin> by_view_gap;
};

// Where the world's unit is arbitrary, a metre is the model's viewing distance
// / kViewDistance_m.
TrainingDistanceBins BinByTrainingDistance(const EvaluatedMethod& method,
                                           double confidence_threshold);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_TRAINING_DISTANCE_H_
