#include "server/core/pose/pnp.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "common/base/random.h"

namespace treeline::pose {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// Survivors are refined locally once there are so few.
constexpr size_t kRefinedSurvivors = 16;
constexpr int kLocalIterations = 3;
constexpr double kInitialScale = 3;
// Nothing nearer than this (units of the world) is in front of the camera.
constexpr double kMinDepth = 1e-6;

struct Hypothesis {
  geometry::Rigid3 camera_from_world;
  double energy = 0;
};

// Rays and best predictions as separate float arrays: scoring a hypothesis is
// then a loop that compilers vectorise.
struct PackedPixels {
  explicit PackedPixels(const PixelPredictions& scene) {
    const size_t n = scene.size();
    for (std::vector<float>* v : {&u, &v_, &x, &y, &z}) v->resize(n);
    for (size_t i = 0; i < n; ++i) {
      const geometry::Vec3& world = scene.at(i, 0).mean_in_world;
      u[i] = static_cast<float>(scene.ray[i].x);
      v_[i] = static_cast<float>(scene.ray[i].y);
      x[i] = static_cast<float>(world.x);
      y[i] = static_cast<float>(world.y);
      z[i] = static_cast<float>(world.z);
    }
  }
  std::vector<float> u, v_, x, y, z;
};

// Sum over pixels [begin, end) of min(1, |error|^2 / inlier_distance^2).
double TruncatedEnergy(const PackedPixels& p,
                       const geometry::Rigid3& camera_from_world,
                       double inlier_distance, size_t begin, size_t end) {
  const geometry::Mat3 r = camera_from_world.rotation.Matrix();
  float m[9];
  for (size_t i = 0; i < 9; ++i) m[i] = static_cast<float>(r.m[i]);
  const float tx = static_cast<float>(camera_from_world.translation.x);
  const float ty = static_cast<float>(camera_from_world.translation.y);
  const float tz = static_cast<float>(camera_from_world.translation.z);
  const float scale =
      static_cast<float>(1 / (inlier_distance * inlier_distance));
  // Eight partial sums in a fixed order: vectorisable, and the same on every
  // machine.
  float sums[8] = {};
  for (size_t base = begin; base < end; base += 8) {
    const size_t count = std::min<size_t>(8, end - base);
    for (size_t lane = 0; lane < count; ++lane) {
      const size_t i = base + lane;
      const float px = m[0] * p.x[i] + m[1] * p.y[i] + m[2] * p.z[i] + tx;
      const float py = m[3] * p.x[i] + m[4] * p.y[i] + m[5] * p.z[i] + ty;
      const float pz = m[6] * p.x[i] + m[7] * p.y[i] + m[8] * p.z[i] + tz;
      const float safe_z = std::max(pz, 1e-6f);
      const float du = px / safe_z - p.u[i];
      const float dv = py / safe_z - p.v_[i];
      sums[lane] += std::min(1.0f, (du * du + dv * dv) * scale);
    }
  }
  double energy = 0;
  for (float sum : sums) energy += static_cast<double>(sum);
  return energy;
}

// A rigid transform as its matrix: faster than quaternions for many points.
struct CameraFromWorld {
  explicit CameraFromWorld(const geometry::Rigid3& pose)
      : r(pose.rotation.Matrix()), t(pose.translation) {}
  geometry::Vec3 operator*(geometry::Vec3 point) const { return r * point + t; }

  geometry::Mat3 r;
  geometry::Vec3 t;
};

double SquaredError(const CameraFromWorld& camera_from_world,
                    geometry::Vec3 point, camera::Pixel ray) {
  const geometry::Vec3 p = camera_from_world * point;
  if (p.z < kMinDepth) return std::numeric_limits<double>::infinity();
  const double du = p.x / p.z - ray.x;
  const double dv = p.y / p.z - ray.y;
  return du * du + dv * dv;
}

std::optional<geometry::Rigid3> DrawHypothesis(const PixelPredictions& scene,
                                               const PnpOptions& options,
                                               uint64_t index) {
  base::Random random(options.seed, 0x706e700000000000 + index);
  const uint32_t n = static_cast<uint32_t>(scene.size());
  // Rays closer than this make a badly conditioned triangle.
  const double min_side = 3 * options.inlier_distance;
  for (int draw = 0; draw < options.draws; ++draw) {
    std::array<camera::Pixel, 4> ray;
    std::array<geometry::Vec3, 4> point;
    for (size_t k = 0; k < 4; ++k) {
      const size_t i = random.NextBelow(n);
      ray[k] = scene.ray[i];
      point[k] = scene.at(i, 0).mean_in_world;
    }
    bool spread = true;
    for (size_t a = 0; a < 3; ++a) {
      const camera::Pixel& p = ray[a];
      const camera::Pixel& q = ray[(a + 1) % 3];
      spread = spread && std::hypot(p.x - q.x, p.y - q.y) >= min_side;
    }
    if (!spread) continue;
    const P3pSolutions solutions =
        SolveP3p({ray[0], ray[1], ray[2]}, {point[0], point[1], point[2]});
    double best = options.inlier_distance * options.inlier_distance;
    std::optional<geometry::Rigid3> pose;
    for (int s = 0; s < solutions.count; ++s) {
      const geometry::Rigid3& candidate =
          solutions.camera_from_world[static_cast<size_t>(s)];
      const double error =
          SquaredError(CameraFromWorld(candidate), point[3], ray[3]);
      if (error < best) {
        best = error;
        pose = candidate;
      }
    }
    if (pose) return pose;
  }
  return std::nullopt;
}

// The prediction of pixel i that reprojects nearest.
struct Nearest {
  int k = -1;
  double squared_distance = std::numeric_limits<double>::infinity();
};
Nearest NearestPrediction(const PixelPredictions& scene,
                          const CameraFromWorld& camera_from_world, size_t i,
                          int per_pixel) {
  Nearest nearest;
  for (int k = 0; k < per_pixel; ++k) {
    const double distance = SquaredError(
        camera_from_world, scene.at(i, k).mean_in_world, scene.ray[i]);
    if (distance < nearest.squared_distance) nearest = {k, distance};
  }
  return nearest;
}

struct NormalEquations {
  Matrix6 h = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
  double weighted_squares = 0;
  double weights = 0;
};

// Adds pixel i with prediction k to the upper triangle: the residual's
// derivative is that of
//   camera_from_world * X = R^T (X - t),  R' = Exp(w) R,  t' = t + d
// with respect to (d, w), both in the world frame.
void Accumulate(const PixelPredictions& scene, size_t i, int k,
                const CameraFromWorld& camera_from_world,
                geometry::Vec3 position, double robust, NormalEquations& n) {
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
  for (int u = 0; u < 6; ++u) {
    const double w0 =
        weight[0][0] * jacobian[0][u] + weight[1][0] * jacobian[1][u];
    const double w1 =
        weight[0][1] * jacobian[0][u] + weight[1][1] * jacobian[1][u];
    for (int v = u; v < 6; ++v) {
      n.h(u, v) += w0 * jacobian[0][v] + w1 * jacobian[1][v];
    }
    n.g(u) += w0 * residual[0] + w1 * residual[1];
  }
  n.weighted_squares += residual[0] * (weight[0][0] * residual[0] +
                                       2 * weight[0][1] * residual[1]) +
                        residual[1] * weight[1][1] * residual[1];
  n.weights += robust;
}

// One Gauss-Newton step on the pixels within three robust scales; false if
// they do not determine a pose.
bool Step(const PixelPredictions& scene, double scale, int per_pixel,
          geometry::Rigid3& world_from_camera, NormalEquations& n) {
  n = NormalEquations{};
  const CameraFromWorld camera_from_world(world_from_camera.Inverse());
  const double scale2 = scale * scale;
  for (size_t i = 0; i < scene.size(); ++i) {
    const Nearest nearest =
        NearestPrediction(scene, camera_from_world, i, per_pixel);
    if (!(nearest.squared_distance <= 9 * scale2)) continue;
    const double root = scale2 / (scale2 + nearest.squared_distance);
    Accumulate(scene, i, nearest.k, camera_from_world,
               world_from_camera.translation, root * root, n);
  }
  n.h.triangularView<Eigen::StrictlyLower>() = n.h.transpose();
  const Eigen::LDLT<Matrix6> factors(n.h);
  if (n.weights < 3 || factors.info() != Eigen::Success ||
      !(factors.rcond() > 1e-14)) {
    return false;
  }
  const Vector6 step = -factors.solve(n.g);
  world_from_camera.translation =
      world_from_camera.translation + geometry::Vec3{step[0], step[1], step[2]};
  world_from_camera.rotation = geometry::Normalized(
      geometry::Rotation3::FromAxisAngle({step[3], step[4], step[5]}) *
      world_from_camera.rotation);
  return geometry::IsFinite(world_from_camera);
}

}  // namespace

std::optional<geometry::Rigid3> PreemptivePnp(const PixelPredictions& scene,
                                              const PnpOptions& options,
                                              const std::stop_token& stop) {
  if (scene.size() < 4) return std::nullopt;
  std::vector<Hypothesis> alive;
  for (int h = 0; h < options.hypotheses; ++h) {
    if (stop.stop_requested()) return std::nullopt;
    if (auto pose = DrawHypothesis(scene, options, static_cast<uint64_t>(h))) {
      alive.push_back({*pose, 0});
    }
  }
  if (alive.empty()) return std::nullopt;
  const PackedPixels pixels(scene);
  const auto better = [](const Hypothesis& a, const Hypothesis& b) {
    return a.energy < b.energy;
  };
  size_t seen = 0;
  while (alive.size() > 1 && seen < scene.size()) {
    if (stop.stop_requested()) return std::nullopt;
    const size_t end =
        std::min(scene.size(), seen + static_cast<size_t>(options.block));
    for (Hypothesis& h : alive) {
      h.energy += TruncatedEnergy(pixels, h.camera_from_world,
                                  options.inlier_distance, seen, end);
    }
    seen = end;
    std::stable_sort(alive.begin(), alive.end(), better);
    alive.resize((alive.size() + 1) / 2);
    if (alive.size() > kRefinedSurvivors) continue;
    for (Hypothesis& h : alive) {
      geometry::Rigid3 refined = h.camera_from_world.Inverse();
      NormalEquations equations;
      bool solved = true;
      for (int k = 0; k < kLocalIterations && solved; ++k) {
        solved = Step(scene, options.inlier_distance, 1, refined, equations);
      }
      if (!solved) continue;
      const geometry::Rigid3 camera_from_world = refined.Inverse();
      const double energy = TruncatedEnergy(pixels, camera_from_world,
                                            options.inlier_distance, 0, seen);
      if (energy < h.energy) h = {camera_from_world, energy};
    }
  }
  std::stable_sort(alive.begin(), alive.end(), better);
  return alive.front().camera_from_world.Inverse();
}

std::optional<PnpResult> RefinePnp(const PixelPredictions& scene,
                                   const geometry::Rigid3& world_from_camera,
                                   const PnpRefinementOptions& options) {
  geometry::Rigid3 pose = world_from_camera;
  NormalEquations equations;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    const double progress = std::min(
        1.0, static_cast<double>(iteration) / (0.5 * options.iterations));
    const double scale =
        options.robust_scale * std::pow(kInitialScale, 1 - progress);
    if (!Step(scene, scale, scene.per_pixel, pose, equations)) {
      return std::nullopt;
    }
  }
  PnpResult result;
  result.world_from_camera = pose;
  // The noise model may be off by a factor: scale by the residuals' own size.
  const double degrees = std::max(1.0, 2 * equations.weights - 6);
  const Matrix6 covariance =
      equations.h.ldlt().solve(Matrix6::Identity()) *
      std::max(1.0, equations.weighted_squares / degrees);
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) {
      result.covariance[static_cast<size_t>(6 * r + c)] =
          0.5 * (covariance(r, c) + covariance(c, r));
    }
  }
  const CameraFromWorld camera_from_world(pose.Inverse());
  const double limit = options.inlier_distance * options.inlier_distance;
  result.supported.assign(scene.size(), -1);
  for (size_t i = 0; i < scene.size(); ++i) {
    const Nearest nearest =
        NearestPrediction(scene, camera_from_world, i, scene.per_pixel);
    if (nearest.squared_distance <= limit) {
      result.supported[i] = static_cast<int8_t>(nearest.k);
      ++result.inliers;
    }
  }
  return result;
}

}  // namespace treeline::pose
