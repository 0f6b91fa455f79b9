#include "server/core/pose/rigid_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "Eigen/Cholesky"
#include "Eigen/Core"

namespace treeline {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kInitialScale = 3;

struct NearestPrediction {
  int k = 0;
  double squared_distance = 0;
  Vec3 residual;
};

NearestPrediction Nearest(const ScenePredictions& scene, size_t i,
                          Vec3 point_in_world) {
  NearestPrediction nearest;
  nearest.squared_distance = std::numeric_limits<double>::infinity();
  for (int k = 0; k < scene.per_point; ++k) {
    const Vec3 residual = point_in_world - scene.at(i, k).mean_in_world;
    const double distance = SquaredNorm(residual);
    if (distance < nearest.squared_distance) {
      nearest = {k, distance, residual};
    }
  }
  return nearest;
}

// The inverse of a symmetric 3x3 given as xx xy xz yy yz zz.
std::array<double, 6> InvertSymmetric(const std::array<double, 6>& a) {
  const double xx = a[3] * a[5] - a[4] * a[4];
  const double xy = a[2] * a[4] - a[1] * a[5];
  const double xz = a[1] * a[4] - a[2] * a[3];
  const double d = 1 / (a[0] * xx + a[1] * xy + a[2] * xz);
  return {d * xx,
          d * xy,
          d * xz,
          d * (a[0] * a[5] - a[2] * a[2]),
          d * (a[1] * a[2] - a[0] * a[4]),
          d * (a[0] * a[3] - a[1] * a[1])};
}

// Accumulates J^T W J and J^T W r for r with derivative [I, -[q]x] with
// respect to (translation, rotation), q = R x. w: xx xy xz yy yz zz.
void Accumulate(const std::array<double, 6>& w, Vec3 q, Vec3 r, Matrix6& h,
                Vector6& g) {
  const double wm[3][3] = {
      {w[0], w[1], w[2]}, {w[1], w[3], w[4]}, {w[2], w[4], w[5]}};
  // B = [q]x^T ... derivative of Exp(a) q is -[q]x a.
  const double b[3][3] = {{0, q.z, -q.y}, {-q.z, 0, q.x}, {q.y, -q.x, 0}};
  double wb[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      wb[i][j] = wm[i][0] * b[0][j] + wm[i][1] * b[1][j] + wm[i][2] * b[2][j];
    }
  }
  const double rr[3] = {r.x, r.y, r.z};
  double wr[3];
  for (int i = 0; i < 3; ++i) {
    wr[i] = wm[i][0] * rr[0] + wm[i][1] * rr[1] + wm[i][2] * rr[2];
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      h(i, j) += wm[i][j];
      h(i, 3 + j) += wb[i][j];
      h(3 + i, 3 + j) +=
          b[0][i] * wb[0][j] + b[1][i] * wb[1][j] + b[2][i] * wb[2][j];
    }
    g(i) += wr[i];
    g(3 + i) += b[0][i] * wr[0] + b[1][i] * wr[1] + b[2][i] * wr[2];
  }
}

// (S + s^2 v v^T + model^2 I)^-1 with v a unit vector in the world.
std::array<double, 6> Information(const ScenePrediction& prediction, Vec3 ray,
                                  double depth_sigma_m, double model_sigma_m) {
  std::array<double, 6> c = prediction.covariance;
  const double s = depth_sigma_m * depth_sigma_m;
  const double m = model_sigma_m * model_sigma_m;
  c[0] += s * ray.x * ray.x + m;
  c[1] += s * ray.x * ray.y;
  c[2] += s * ray.x * ray.z;
  c[3] += s * ray.y * ray.y + m;
  c[4] += s * ray.y * ray.z;
  c[5] += s * ray.z * ray.z + m;
  return InvertSymmetric(c);
}

}  // namespace

std::optional<RefinedPose> RefineRigid(const ScenePredictions& scene,
                                       const Rigid3& world_from_camera,
                                       const RefinementOptions& options) {
  RefinedPose refined;
  Rigid3 pose = world_from_camera;
  Matrix6 h;
  double weighted_squares = 0;
  double weights = 0;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    const double progress = std::min(
        1.0, static_cast<double>(iteration) / (0.5 * options.iterations));
    const double scale =
        options.robust_scale_m * std::pow(kInitialScale, 1 - progress);
    const double scale2 = scale * scale;
    h.setZero();
    Vector6 g = Vector6::Zero();
    weighted_squares = 0;
    weights = 0;
    for (size_t i = 0; i < scene.size(); ++i) {
      const Vec3 q = pose.rotation * scene.point_in_camera[i];
      const NearestPrediction nearest = Nearest(scene, i, q + pose.translation);
      if (nearest.squared_distance > 9 * scale2) continue;
      const double robust = scale2 * scale2 /
                            ((scale2 + nearest.squared_distance) *
                             (scale2 + nearest.squared_distance));
      std::array<double, 6> w =
          Information(scene.at(i, nearest.k), Normalized(q),
                      scene.depth_sigma_m[i], options.model_sigma_m);
      for (double& entry : w) entry *= robust;
      Accumulate(w, q, nearest.residual, h, g);
      const Vec3 r = nearest.residual;
      weighted_squares +=
          w[0] * r.x * r.x + w[3] * r.y * r.y + w[5] * r.z * r.z +
          2 * (w[1] * r.x * r.y + w[2] * r.x * r.z + w[4] * r.y * r.z);
      weights += robust;
    }
    h.triangularView<Eigen::StrictlyLower>() = h.transpose();
    const Eigen::LDLT<Matrix6> factors(h);
    if (weights < 3 || factors.info() != Eigen::Success ||
        !(factors.rcond() > 1e-12)) {
      return std::nullopt;
    }
    const Vector6 step = -factors.solve(g);
    pose.translation = pose.translation + Vec3{step[0], step[1], step[2]};
    pose.rotation = Normalized(
        Rotation3::FromAxisAngle({step[3], step[4], step[5]}) * pose.rotation);
  }
  refined.world_from_camera = pose;
  // The noise model may be off by a factor: scale by the residuals' own size.
  const double degrees = std::max(1.0, 3 * weights - 6);
  const Matrix6 covariance = h.ldlt().solve(Matrix6::Identity()) *
                             std::max(1.0, weighted_squares / degrees);
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) {
      refined.covariance[static_cast<size_t>(6 * r + c)] =
          0.5 * (covariance(r, c) + covariance(c, r));
    }
  }
  refined.supported.assign(scene.size(), -1);
  for (size_t i = 0; i < scene.size(); ++i) {
    const NearestPrediction nearest =
        Nearest(scene, i, pose * scene.point_in_camera[i]);
    if (nearest.squared_distance <=
        options.inlier_distance_m * options.inlier_distance_m) {
      refined.supported[i] = static_cast<int8_t>(nearest.k);
      ++refined.inliers;
    }
  }
  if (!IsFinite(pose)) return std::nullopt;
  return refined;
}

}  // namespace treeline
