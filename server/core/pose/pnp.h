// Camera pose from pixels and predicted scene coordinates (Perspective-n-
// Point): hypotheses from three points inside preemptive RANSAC with local
// optimisation, then a robust refinement with covariance.
#ifndef SERVER_CORE_POSE_PNP_H_
#define SERVER_CORE_POSE_PNP_H_

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "server/core/pose/scene_predictions.h"

namespace treeline::pose {

// Rays of a camera and, for each, the same number of predictions, best first.
struct PixelPredictions {
  int per_pixel = 1;
  // (x/z, y/z) of the ray through the observed pixel: Camera::Unproject.
  std::vector<camera::Pixel> ray;
  // Standard deviation of the observed position, in units of the ray.
  std::vector<double> ray_sigma;
  // Prediction k of pixel i is predictions[i * per_pixel + k].
  std::vector<ScenePrediction> predictions;

  size_t size() const { return ray.size(); }
  const ScenePrediction& at(size_t i, int k) const {
    return predictions[i * static_cast<size_t>(per_pixel) +
                       static_cast<size_t>(k)];
  }
};

// Up to four camera_from_world that see three points on three rays (P3P;
// Grunert 1841, as in Haralick et al. 1994). Points and rays must not be
// collinear.
struct P3pSolutions {
  std::array<geometry::Rigid3, 4> camera_from_world;
  int count = 0;
};
P3pSolutions SolveP3p(const std::array<camera::Pixel, 3>& rays,
                      const std::array<geometry::Vec3, 3>& points_in_world);

struct PnpOptions {
  uint64_t seed = 0;
  int hypotheses = 256;
  // Pixels scored between two prunings.
  int block = 100;
  // Reprojection errors count in full up to this distance and no further, in
  // units of the ray (pixels over focal length).
  double inlier_distance = 10.0 / 525;
  // Triples drawn for a hypothesis before it is given up: a triple is kept if
  // a fourth pixel is within the inlier distance too.
  int draws = 50;
};

struct PnpResult {
  geometry::Rigid3 world_from_camera;
  geometry::PoseCovariance covariance{};
  int inliers = 0;
  // Which prediction each pixel supports; -1: none (an outlier).
  std::vector<int8_t> supported;
};

// Preemptive RANSAC on reprojection errors of the best predictions; survivors
// are refined locally between prunings (LO-RANSAC, Chum 2003). Pixels must be
// in random order, or in order of confidence. nullopt: nothing was consistent.
// The same input gives the same result.
std::optional<geometry::Rigid3> PreemptivePnp(const PixelPredictions& scene,
                                              const PnpOptions& options,
                                              const std::stop_token& stop);

struct PnpRefinementOptions {
  int iterations = 10;
  // Scale of the robust loss at the last iteration (units of the ray); it
  // starts three times as large and shrinks.
  double robust_scale = 4.0 / 525;
  // Pixels with a prediction reprojected within this distance are inliers.
  double inlier_distance = 8.0 / 525;
};

// Minimises the robust sum of squared reprojection errors (thesis Eq. 3.12),
// each weighted by the observation's noise and the prediction's covariance
// seen from the camera; every pixel picks its nearest prediction anew in each
// iteration. nullopt: the inliers do not determine a pose.
std::optional<PnpResult> RefinePnp(const PixelPredictions& scene,
                                   const geometry::Rigid3& world_from_camera,
                                   const PnpRefinementOptions& options);

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_PNP_H_
