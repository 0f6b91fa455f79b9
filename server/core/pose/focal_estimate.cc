#include "server/core/pose/focal_estimate.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "server/core/pose/parameters.h"
#include "server/core/pose/reprojection.h"

namespace treeline::pose {
namespace {

using Matrix2x7 = Eigen::Matrix<double, 2, 7>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Vector7 = Eigen::Matrix<double, 7, 1>;

// Normal equations of a step of the pose (as in RefineRays, but in the camera's
// frame) and of log(scale).
struct Sum {
  Matrix7 hessian = Matrix7::Zero();
  Vector7 gradient = Vector7::Zero();
  double value = 0;
  double weights = 0;
};

// The point's image under the sought focal length, in units of the rays, and
// its derivatives by a step (v, w) of the point in the camera, p + v + w x p,
// and by log(scale).
Matrix2x7 Derivatives(geometry::Vec3 p, double scale) {
  const double iz = 1 / p.z;
  const double x = p.x * iz;
  const double y = p.y * iz;
  Matrix2x7 j;
  j << iz, 0, -x * iz, -x * y, 1 + x * x, -y, x,  //
      0, iz, -y * iz, -1 - y * y, x * y, x, y;
  return scale * j;
}

Sum SumAt(const RayPredictions& scene,
          const geometry::Rigid3& camera_from_world, double scale,
          double robust_scale) {
  const CameraFromWorld to_camera(camera_from_world);
  const double reach2 =
      kRobustReach * kRobustReach * robust_scale * robust_scale;
  Sum sum;
  for (size_t i = 0; i < scene.size(); ++i) {
    const geometry::Vec3 p = to_camera * scene.at(i, 0).mean_in_world;
    if (p.z < kMinPointDepth) continue;
    const Eigen::Vector2d residual{scale * p.x / p.z - scene.ray[i].x,
                                   scale * p.y / p.z - scene.ray[i].y};
    const double squared = residual.squaredNorm();
    if (!(squared <= reach2)) continue;
    const double root =
        robust_scale * robust_scale / (robust_scale * robust_scale + squared);
    // The prediction's spread, as if it were the same in all directions.
    const double spread = scene.at(i, 0).covariance[0] / (p.z * p.z);
    const double weight =
        root * root /
        (scene.ray_sigma[i] * scene.ray_sigma[i] + scale * scale * spread);
    const Matrix2x7 j = Derivatives(p, scale);
    sum.hessian.noalias() += weight * j.transpose() * j;
    sum.gradient.noalias() += weight * j.transpose() * residual;
    sum.value += weight * squared;
    sum.weights += root * root;
  }
  return sum;
}

geometry::Rigid3 Moved(const geometry::Rigid3& camera_from_world,
                       const Vector7& step) {
  const geometry::Rotation3 turn =
      geometry::Rotation3::FromAxisAngle({step[3], step[4], step[5]});
  return {geometry::Normalized(turn * camera_from_world.rotation),
          turn * camera_from_world.translation +
              geometry::Vec3{step[0], step[1], step[2]}};
}

}  // namespace

std::optional<FocalEstimate> EstimateFocal(
    const RayPredictions& scene, const geometry::Rigid3& world_from_camera,
    double robust_scale) {
  geometry::Rigid3 camera_from_world = world_from_camera.Inverse();
  double log_scale = 0;
  for (int i = 0; i < kFocalIterations; ++i) {
    const double progress = std::min(1.0, 2.0 * i / kFocalIterations);
    const double width =
        robust_scale * std::pow(kInitialFocalRobustScale.value, 1 - progress);
    const Sum sum = SumAt(scene, camera_from_world, std::exp(log_scale), width);
    if (sum.weights < kMinRobustWeights) return std::nullopt;
    const Eigen::LDLT<Matrix7> factors(sum.hessian);
    if (factors.info() != Eigen::Success || !(factors.rcond() > kMinRayRcond)) {
      return std::nullopt;
    }
    const Vector7 step = -factors.solve(sum.gradient);
    camera_from_world = Moved(camera_from_world, step);
    log_scale += step[6];
    if (!geometry::IsFinite(camera_from_world) ||
        !(std::abs(log_scale) < kMaxLogFocalScale)) {
      return std::nullopt;
    }
    if (i + 1 < kFocalIterations) continue;
    const double degrees = std::max(1.0, 2 * sum.weights - 7);
    const double variance =
        factors.solve(Vector7::Unit(6))[6] * std::max(1.0, sum.value / degrees);
    return FocalEstimate{std::exp(log_scale), std::sqrt(variance)};
  }
  return std::nullopt;
}

}  // namespace treeline::pose
