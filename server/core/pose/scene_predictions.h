// What a forest, or a match of features, says: where samples of a frame are in
// the scene. What the pose solvers read.
#ifndef SERVER_CORE_POSE_SCENE_PREDICTIONS_H_
#define SERVER_CORE_POSE_SCENE_PREDICTIONS_H_

#include <array>
#include <cstdint>
#include <vector>

#include "common/camera/camera.h"
#include "common/geometry/vector3.h"

namespace treeline::pose {

// A predicted scene coordinate with its uncertainty.
struct ScenePrediction {
  geometry::Vec3 mean_in_world;
  // m^2: xx xy xz yy yz zz.
  std::array<double, 6> covariance{};
};

// For each sample the same number of predictions, best first.
struct SamplePredictions {
  int per_sample = 1;
  // Prediction k of sample i is predictions[i * per_sample + k].
  std::vector<ScenePrediction> predictions;

  const ScenePrediction& at(size_t i, int k) const {
    return predictions[i * static_cast<size_t>(per_sample) +
                       static_cast<size_t>(k)];
  }
};

// Samples with depth: measured points.
struct PointPredictions : SamplePredictions {
  std::vector<geometry::Vec3> point_in_camera;
  std::vector<double> depth_sigma_m;
  // Of the line that each point lies on, of length 1: the point's prediction
  // says where the line is, and nothing of the place along it. Zero for a point
  // on no line; empty if none lies on one.
  std::vector<geometry::Vec3> line_direction_in_camera;

  size_t size() const { return point_in_camera.size(); }
  bool has_lines() const { return !line_direction_in_camera.empty(); }
  bool is_on_line(size_t i) const {
    return has_lines() && line_direction_in_camera[i] != geometry::Vec3{};
  }
};

// Samples without depth: rays of a camera.
struct RayPredictions : SamplePredictions {
  // (x/z, y/z) of the ray through the observed pixel: Camera::Unproject.
  std::vector<camera::Pixel> ray;
  // Standard deviation of the observed position, in units of the ray.
  std::vector<double> ray_sigma;

  size_t size() const { return ray.size(); }
};

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_SCENE_PREDICTIONS_H_
