#include "server/core/pose/point_solver.h"

#include <cmath>

#include "common/geometry/kabsch.h"
#include "server/core/pose/parameters.h"

namespace treeline::pose {

PointSolver::PointSolver(const PointPredictions& scene,
                         const PointSolverOptions& options)
    : scene_(scene), options_(options) {
  for (size_t i = 0; i < scene.size(); ++i) {
    in_camera_.Add(scene.point_in_camera[i]);
    in_world_.Add(scene.at(i, 0).mean_in_world);
  }
}

std::optional<geometry::Rigid3> PointSolver::Draw(base::Random& random) const {
  const uint32_t n = static_cast<uint32_t>(scene_.size());
  size_t corner[3];
  for (size_t& c : corner) c = random.NextBelow(n);
  for (size_t a = 0; a < 3; ++a) {
    const size_t i = corner[a];
    const size_t j = corner[(a + 1) % 3];
    const double side =
        geometry::Norm(scene_.point_in_camera[i] - scene_.point_in_camera[j]);
    if (side < options_.min_side_m) return std::nullopt;
    const double predicted = geometry::Norm(scene_.at(i, 0).mean_in_world -
                                            scene_.at(j, 0).mean_in_world);
    if (!(std::abs(side - predicted) <= options_.side_tolerance_m)) {
      return std::nullopt;
    }
  }
  geometry::Kabsch kabsch;
  for (const size_t c : corner) {
    kabsch.Add(scene_.at(c, 0).mean_in_world, scene_.point_in_camera[c]);
  }
  return kabsch.Solve();
}

double PointSolver::Cost(const geometry::Rigid3& world_from_camera,
                         size_t begin, size_t end) const {
  const FloatTransform p(world_from_camera);
  const float* const cx = in_camera_.x.data();
  const float* const cy = in_camera_.y.data();
  const float* const cz = in_camera_.z.data();
  const float* const wx = in_world_.x.data();
  const float* const wy = in_world_.y.data();
  const float* const wz = in_world_.z.data();
  return TruncatedCost(begin, end, options_.inlier_distance_m, [&](size_t i) {
    const float dx =
        p.m[0] * cx[i] + p.m[1] * cy[i] + p.m[2] * cz[i] + p.tx - wx[i];
    const float dy =
        p.m[3] * cx[i] + p.m[4] * cy[i] + p.m[5] * cz[i] + p.ty - wy[i];
    const float dz =
        p.m[6] * cx[i] + p.m[7] * cy[i] + p.m[8] * cz[i] + p.tz - wz[i];
    return dx * dx + dy * dy + dz * dz;
  });
}

geometry::Rigid3 PointSolver::Refitted(
    const geometry::Rigid3& world_from_camera, size_t end) const {
  geometry::Kabsch kabsch;
  for (size_t i = 0; i < end; ++i) {
    const geometry::Vec3& world = scene_.at(i, 0).mean_in_world;
    const geometry::Vec3& camera = scene_.point_in_camera[i];
    if (geometry::SquaredNorm(world_from_camera * camera - world) <=
        options_.inlier_distance_m * options_.inlier_distance_m) {
      kabsch.Add(world, camera);
    }
  }
  return kabsch.Solve().value_or(world_from_camera);
}

void PointSolver::Improve(Hypothesis<geometry::Rigid3>& hypothesis, size_t seen,
                          size_t /*survivors*/) const {
  hypothesis.model = Refitted(hypothesis.model, seen);
  hypothesis.cost = Cost(hypothesis.model, 0, seen);
}

geometry::Rigid3 PointSolver::Finish(
    const geometry::Rigid3& world_from_camera) const {
  geometry::Rigid3 pose = world_from_camera;
  for (int i = 0; i < kFinalRefits; ++i) pose = Refitted(pose, scene_.size());
  return pose;
}

}  // namespace treeline::pose
