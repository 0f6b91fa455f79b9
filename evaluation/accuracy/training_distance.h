// How far cameras are from those that a model was trained with, and how
// accuracy falls with it.
#ifndef EVALUATION_ACCURACY_TRAINING_DISTANCE_H_
#define EVALUATION_ACCURACY_TRAINING_DISTANCE_H_

#include <optional>
#include <vector>

#include "common/geometry/rigid3.h"
#include "evaluation/accuracy/evaluation.h"

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

// Frames at about the same distance from training.
struct DistanceGroup {
  int frames = 0;
  double distance_m = 0;  // combined, on average
  double correct = 0;     // share within 5 cm and 5 degrees, in [0, 1]
  // Over localized frames; nullopt: none is.
  std::optional<double> median_translation_m;
};

// Five groups of as many scored frames (fewer if there are fewer frames), from
// those nearest to a training camera to those farthest away. Empty if there is
// no training pose or no ground truth.
std::vector<DistanceGroup> GroupByTrainingDistance(
    const std::vector<FrameResult>& results,
    const std::vector<geometry::Rigid3>& training_poses);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_TRAINING_DISTANCE_H_
