// What the forest says, as the pose solvers read it.
#ifndef SERVER_CORE_POSE_SCENE_PREDICTIONS_H_
#define SERVER_CORE_POSE_SCENE_PREDICTIONS_H_

#include <array>
#include <cstdint>
#include <vector>

#include "common/geometry/vector3.h"

namespace treeline::pose {

// A predicted scene coordinate with its uncertainty.
struct ScenePrediction {
  geometry::Vec3 mean_in_world;
  // m^2: xx xy xz yy yz zz.
  std::array<double, 6> covariance{};
};

// Measured points and, for each, the same number of predictions, best first.
struct ScenePredictions {
  int per_point = 1;
  std::vector<geometry::Vec3> point_in_camera;
  std::vector<double> depth_sigma_m;
  // Of the line that each point lies on, of length 1: the point's prediction
  // says where the line is, and nothing of the place along it. Zero for a point
  // on no line; empty if none lies on one.
  std::vector<geometry::Vec3> line_direction_in_camera;
  // Prediction k of point i is predictions[i * per_point + k].
  std::vector<ScenePrediction> predictions;

  size_t size() const { return point_in_camera.size(); }
  bool has_lines() const { return !line_direction_in_camera.empty(); }
  bool is_on_line(size_t i) const {
    return has_lines() && line_direction_in_camera[i] != geometry::Vec3{};
  }
  const ScenePrediction& at(size_t i, int k) const {
    return predictions[i * static_cast<size_t>(per_point) +
                       static_cast<size_t>(k)];
  }
};

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_SCENE_PREDICTIONS_H_
