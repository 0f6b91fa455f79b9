#include "server/core/pose/ray_refinement.h"

#include <algorithm>
#include <limits>

#include "server/core/pose/normal_equations.h"
#include "server/core/pose/parameters.h"
#include "server/core/pose/reprojection.h"

namespace treeline::pose {
namespace {

// Adds ray i with prediction k to the upper triangle: the residual's
// derivative is that of
//   camera_from_world * X = R^T (X - t),  R' = Exp(w) R,  t' = t + d
// with respect to (d, w), both in the world frame.
void Accumulate(const RayPredictions& scene, size_t i, int k,
                const CameraFromWorld& camera_from_world,
                geometry::Vec3 position, double robust, RobustSum& sum) {
  const ScenePrediction& prediction = scene.at(i, k);
  const geometry::Vec3 p = camera_from_world * prediction.mean_in_world;
  const double iz = 1 / p.z;
  const double x = p.x * iz;
  const double y = p.y * iz;
  const double residual[2] = {x - scene.ray[i].x, y - scene.ray[i].y};
  // Derivatives of the projection with respect to the point in the world.
  const geometry::Mat3& r = camera_from_world.r;
  const geometry::Vec3 a[2] = {
      {iz * (r.m[0] - x * r.m[6]), iz * (r.m[1] - x * r.m[7]),
       iz * (r.m[2] - x * r.m[8])},
      {iz * (r.m[3] - y * r.m[6]), iz * (r.m[4] - y * r.m[7]),
       iz * (r.m[5] - y * r.m[8])}};
  const auto& c = prediction.covariance;
  const auto spread = [&](geometry::Vec3 v) {
    return geometry::Vec3{c[0] * v.x + c[1] * v.y + c[2] * v.z,
                          c[1] * v.x + c[3] * v.y + c[4] * v.z,
                          c[2] * v.x + c[4] * v.y + c[5] * v.z};
  };
  const geometry::Vec3 spread_x = spread(a[0]);
  const double noise = scene.ray_sigma[i] * scene.ray_sigma[i];
  const double xx = geometry::Dot(a[0], spread_x) + noise;
  const double xy = geometry::Dot(a[1], spread_x);
  const double yy = geometry::Dot(a[1], spread(a[1])) + noise;
  const double scale = robust / (xx * yy - xy * xy);
  const double weight[2][2] = {{scale * yy, -scale * xy},
                               {-scale * xy, scale * xx}};
  // X - t.
  const geometry::Vec3 q = prediction.mean_in_world - position;
  double jacobian[2][6];
  for (size_t row = 0; row < 2; ++row) {
    const geometry::Vec3 turn = geometry::Cross(a[row], q);
    const double values[6] = {-a[row].x, -a[row].y, -a[row].z,
                              turn.x,    turn.y,    turn.z};
    std::copy(values, values + 6, jacobian[row]);
  }
  for (size_t u = 0; u < 6; ++u) {
    const double w0 =
        weight[0][0] * jacobian[0][u] + weight[1][0] * jacobian[1][u];
    const double w1 =
        weight[0][1] * jacobian[0][u] + weight[1][1] * jacobian[1][u];
    for (size_t v = u; v < 6; ++v) {
      sum.equations.hessian[6 * u + v] +=
          w0 * jacobian[0][v] + w1 * jacobian[1][v];
    }
    sum.equations.gradient[u] += w0 * residual[0] + w1 * residual[1];
  }
  sum.value += residual[0] * (weight[0][0] * residual[0] +
                              2 * weight[0][1] * residual[1]) +
               residual[1] * weight[1][1] * residual[1];
  sum.weights += robust;
}

// PoseResiduals of rays and their best predictions.
class BestRayResiduals {
 public:
  explicit BestRayResiduals(const PackedRays& rays) : rays_(rays) {}

  RobustSum SumAt(const geometry::Rigid3& world_from_camera,
                  double scale) const {
    return SumRays(rays_, world_from_camera, scale);
  }

 private:
  const PackedRays& rays_;
};

// PoseResiduals of rays and the first so many of their predictions.
class RayResiduals {
 public:
  RayResiduals(const RayPredictions& scene, int predictions)
      : scene_(scene), predictions_(predictions) {}

  RobustSum SumAt(const geometry::Rigid3& world_from_camera,
                  double scale) const {
    const CameraFromWorld camera_from_world(world_from_camera.Inverse());
    const double scale2 = scale * scale;
    RobustSum sum;
    for (size_t i = 0; i < scene_.size(); ++i) {
      const NearestPrediction nearest = Nearest(camera_from_world, i);
      if (!(nearest.squared_distance <= kRobustReach * kRobustReach * scale2)) {
        continue;
      }
      const double root = scale2 / (scale2 + nearest.squared_distance);
      Accumulate(scene_, i, nearest.k, camera_from_world,
                 world_from_camera.translation, root * root, sum);
    }
    sum.residuals = 2 * sum.weights;
    return sum;
  }

  NearestPrediction Nearest(const CameraFromWorld& camera_from_world,
                            size_t i) const {
    return NearestOf(predictions_, [&](int k) {
      return SquaredReprojectionError(
          camera_from_world, scene_.at(i, k).mean_in_world, scene_.ray[i]);
    });
  }

 private:
  const RayPredictions& scene_;
  const int predictions_;
};

}  // namespace

std::optional<RefinedPose> RefineRays(const RayPredictions& scene,
                                      const geometry::Rigid3& world_from_camera,
                                      const RayRefinementOptions& options) {
  RayResiduals residuals(scene, scene.per_sample);
  const RobustOptions robust = {.iterations = options.iterations,
                                .robust_scale = options.robust_scale,
                                .initial_scale = kInitialRobustScale,
                                .min_rcond = kMinRayRcond};
  std::optional<Minimum> minimum;
  if (scene.per_sample == 1) {
    const PackedRays rays(scene);
    BestRayResiduals best(rays);
    minimum = MinimizeRobustly(best, world_from_camera, robust);
  } else {
    minimum = MinimizeRobustly(residuals, world_from_camera, robust);
  }
  if (!minimum) return std::nullopt;
  const CameraFromWorld camera_from_world(minimum->world_from_camera.Inverse());
  return SupportedPose(
      *minimum, scene.size(), scene.size(), options.inlier_distance,
      [&](size_t i) { return residuals.Nearest(camera_from_world, i); });
}

std::optional<geometry::Rigid3> RefineOnBestPredictions(
    const PackedRays& rays, const geometry::Rigid3& world_from_camera,
    double robust_scale, int iterations) {
  BestRayResiduals residuals(rays);
  const std::optional<Minimum> minimum =
      MinimizeRobustly(residuals, world_from_camera,
                       {.iterations = iterations,
                        .robust_scale = robust_scale,
                        .min_rcond = kMinRayRcond});
  if (!minimum) return std::nullopt;
  return minimum->world_from_camera;
}

}  // namespace treeline::pose
