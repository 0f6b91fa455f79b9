#include "nav_agent/rgbd_slam/pose_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "common/base/random.h"
#include "common/geometry/kabsch.h"

namespace treeline::rgbd_slam {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

struct NormalEquations {
  Matrix6 hessian = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();

  void Add(const Vector6& row, double residual, double weight) {
    hessian.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
    gradient += weight * residual * row;
  }
};

// Derivatives by (translation, rotation) of a motion of the camera's frame:
// point <- Exp(rotation) * point + translation.
void AddSighting(const PointSighting& sighting, const Pinhole& pinhole,
                 const geometry::Mat3& rotation, geometry::Vec3 translation,
                 NormalEquations& equations) {
  const geometry::Vec3 p = rotation * sighting.point_in_map + translation;
  if (p.z <= 0.05) return;
  const double inverse_z = 1 / p.z;
  const double x = p.x * inverse_z;
  const double y = p.y * inverse_z;
  const double inverse_sigma = 1 / sighting.sigma_px;
  const double u =
      inverse_sigma * (pinhole.fx * x + pinhole.cx - sighting.pixel.x);
  const double v =
      inverse_sigma * (pinhole.fy * y + pinhole.cy - sighting.pixel.y);
  double squared = u * u + v * v;
  double depth_error = 0;
  double inverse_depth_sigma = 0;
  double limit = kMaxSquaredError2;
  if (sighting.depth_m > 0) {
    inverse_depth_sigma = 1 / FeatureDepthSigma_m(sighting.depth_m);
    depth_error = inverse_depth_sigma * (p.z - sighting.depth_m);
    squared += depth_error * depth_error;
    limit = kMaxSquaredError3;
  }
  const double weight =
      squared <= limit ? 1 : std::sqrt(limit / squared);  // Huber
  const double fx = inverse_sigma * pinhole.fx;
  const double fy = inverse_sigma * pinhole.fy;
  Vector6 row;
  row << fx * inverse_z, 0, -fx * x * inverse_z, -fx * x * y, fx * (1 + x * x),
      -fx * y;
  equations.Add(row, u, weight);
  row << 0, fy * inverse_z, -fy * y * inverse_z, -fy * (1 + y * y), fy * x * y,
      fy * x;
  equations.Add(row, v, weight);
  if (sighting.depth_m > 0) {
    row << 0, 0, inverse_depth_sigma, inverse_depth_sigma * p.y,
        -inverse_depth_sigma * p.x, 0;
    equations.Add(row, depth_error, weight);
  }
}

// One Gauss-Newton step; false if it moved next to nothing or cannot be made.
bool Step(std::span<const PointSighting> sightings,
          const std::vector<bool>& is_used, const Pinhole& pinhole,
          geometry::Rigid3& camera_from_map) {
  NormalEquations equations;
  const geometry::Mat3 rotation = camera_from_map.rotation.Matrix();
  for (size_t i = 0; i < sightings.size(); ++i) {
    if (!is_used[i]) continue;
    AddSighting(sightings[i], pinhole, rotation, camera_from_map.translation,
                equations);
  }
  equations.hessian.diagonal().array() += 1e-6;
  const Eigen::LDLT<Matrix6, Eigen::Lower> factor(equations.hessian);
  const Vector6 step = factor.solve(-equations.gradient);
  if (factor.info() != Eigen::Success || !step.allFinite()) return false;
  const geometry::Rigid3 motion = {
      .rotation =
          geometry::Rotation3::FromAxisAngle({step[3], step[4], step[5]}),
      .translation = {step[0], step[1], step[2]}};
  camera_from_map = motion * camera_from_map;
  camera_from_map.rotation = geometry::Normalized(camera_from_map.rotation);
  return step.head<3>().norm() > 1e-5 || step.tail<3>().norm() > 1e-5;
}

int CountExplained(std::span<const PointSighting> sightings,
                   const Pinhole& pinhole,
                   const geometry::Rigid3& camera_from_map,
                   std::vector<bool>& is_inlier) {
  int count = 0;
  for (size_t i = 0; i < sightings.size(); ++i) {
    is_inlier[i] = IsExplained(sightings[i], pinhole, camera_from_map);
    count += is_inlier[i] ? 1 : 0;
  }
  return count;
}

// For hypotheses of three noisy points: three times the usual deviations.
bool IsNear(const PointSighting& sighting, const Pinhole& pinhole,
            geometry::Vec3 point_in_camera) {
  if (point_in_camera.z <= 0.05) return false;
  const camera::Pixel seen = pinhole.Project(point_in_camera);
  const double limit_px = 3 * 2.45 * sighting.sigma_px;
  return std::abs(seen.x - sighting.pixel.x) <= limit_px &&
         std::abs(seen.y - sighting.pixel.y) <= limit_px;
}

int CountNear(std::span<const PointSighting> sightings, const Pinhole& pinhole,
              const geometry::Rigid3& camera_from_map) {
  const geometry::Mat3 rotation = camera_from_map.rotation.Matrix();
  int count = 0;
  for (const PointSighting& sighting : sightings) {
    const geometry::Vec3 p =
        rotation * sighting.point_in_map + camera_from_map.translation;
    count += IsNear(sighting, pinhole, p) ? 1 : 0;
  }
  return count;
}

}  // namespace

double FeatureDepthSigma_m(double depth_m) {
  return 0.004 + 0.004 * depth_m * depth_m;
}

double SquaredError(const PointSighting& sighting, const Pinhole& pinhole,
                    const geometry::Rigid3& camera_from_map) {
  const geometry::Vec3 p = camera_from_map * sighting.point_in_map;
  if (p.z <= 0.05) return std::numeric_limits<double>::infinity();
  const camera::Pixel seen = pinhole.Project(p);
  const double u = (seen.x - sighting.pixel.x) / sighting.sigma_px;
  const double v = (seen.y - sighting.pixel.y) / sighting.sigma_px;
  double squared = u * u + v * v;
  if (sighting.depth_m > 0) {
    const double d =
        (p.z - sighting.depth_m) / FeatureDepthSigma_m(sighting.depth_m);
    squared += d * d;
  }
  return squared;
}

bool IsExplained(const PointSighting& sighting, const Pinhole& pinhole,
                 const geometry::Rigid3& camera_from_map) {
  return SquaredError(sighting, pinhole, camera_from_map) <=
         (sighting.depth_m > 0 ? kMaxSquaredError3 : kMaxSquaredError2);
}

SolvedPose SolvePose(std::span<const PointSighting> sightings,
                     const Pinhole& pinhole,
                     const geometry::Rigid3& initial_camera_from_map) {
  constexpr int kRounds = 3;
  constexpr int kSteps = 6;
  constexpr size_t kMinSightings = 6;
  SolvedPose solved{.camera_from_map = initial_camera_from_map,
                    .is_inlier = std::vector<bool>(sightings.size(), true)};
  if (sightings.size() < kMinSightings) {
    solved.is_inlier.assign(sightings.size(), false);
    return solved;
  }
  for (int round = 0; round < kRounds; ++round) {
    for (int step = 0; step < kSteps; ++step) {
      if (!Step(sightings, solved.is_inlier, pinhole, solved.camera_from_map)) {
        break;
      }
    }
    solved.inliers = CountExplained(sightings, pinhole, solved.camera_from_map,
                                    solved.is_inlier);
    if (solved.inliers < static_cast<int>(kMinSightings)) break;
  }
  return solved;
}

std::optional<SolvedPose> FindPose(std::span<const PointSighting> sightings,
                                   const Pinhole& pinhole, int min_inliers,
                                   uint64_t seed, uint64_t stream) {
  constexpr int kHypotheses = 1000;
  std::vector<size_t> with_depth;
  for (size_t i = 0; i < sightings.size(); ++i) {
    if (sightings[i].depth_m > 0) with_depth.push_back(i);
  }
  if (with_depth.size() < 3 ||
      static_cast<int>(sightings.size()) < min_inliers) {
    return std::nullopt;
  }
  base::Random random(seed, stream);
  geometry::Rigid3 best;
  int best_count = 0;
  int hypotheses = kHypotheses;
  for (int h = 0; h < hypotheses; ++h) {
    geometry::Kabsch kabsch;
    std::array<geometry::Vec3, 3> in_camera;
    std::array<geometry::Vec3, 3> in_map;
    for (size_t k = 0; k < 3; ++k) {
      const PointSighting& sighting = sightings[with_depth[random.NextBelow(
          static_cast<uint32_t>(with_depth.size()))]];
      in_camera[k] = pinhole.PointAt(sighting.pixel, sighting.depth_m);
      in_map[k] = sighting.point_in_map;
      kabsch.Add(in_camera[k], in_map[k]);
    }
    // Three points that keep their distances, to a tenth, are worth a look.
    bool is_rigid = true;
    for (size_t k = 0; k < 3; ++k) {
      const double a = geometry::Norm(in_camera[k] - in_camera[(k + 1) % 3]);
      const double b = geometry::Norm(in_map[k] - in_map[(k + 1) % 3]);
      if (a < 0.05 || std::abs(a - b) > 0.05 + 0.1 * b) is_rigid = false;
    }
    if (!is_rigid) continue;
    const std::optional<geometry::Rigid3> pose = kabsch.Solve();
    if (!pose) continue;
    const int count = CountNear(sightings, pinhole, *pose);
    if (count <= best_count) continue;
    best_count = count;
    best = *pose;
    const double share =
        static_cast<double>(count) / static_cast<double>(sightings.size());
    // Enough draws for three right ones in a row with a chance of 99.9 %.
    const double all_right = std::min(0.999, share * share * share * 0.5);
    hypotheses = std::min(
        kHypotheses,
        std::max(h + 1,
                 static_cast<int>(std::log(0.001) / std::log(1 - all_right))));
  }
  if (best_count < std::max(6, min_inliers / 2)) return std::nullopt;
  std::vector<PointSighting> near;
  for (const PointSighting& sighting : sightings) {
    if (IsNear(sighting, pinhole, best * sighting.point_in_map)) {
      near.push_back(sighting);
    }
  }
  SolvedPose solved = SolvePose(near, pinhole, best);
  solved.is_inlier.resize(sightings.size());
  solved.inliers = CountExplained(sightings, pinhole, solved.camera_from_map,
                                  solved.is_inlier);
  if (solved.inliers < min_inliers) return std::nullopt;
  return solved;
}

}  // namespace treeline::rgbd_slam
