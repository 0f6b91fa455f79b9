#include "server/core/pose/point_solver.h"

#include <cmath>

#include "common/geometry/kabsch.h"
#include "server/core/pose/parameters.h"

namespace treeline::pose {

PointSolver::PointSolver(const PointPredictions& scene,
                         const PointSolverOptions& options)
    : scene_(scene), options_(options) {
  pairs_.Reserve(scene.size());
  for (size_t i = 0; i < scene.size(); ++i) {
    pairs_.Add(scene.point_in_camera[i], scene.at(i, 0).mean_in_world);
  }
  pairs_.Pad();
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
  return TruncatedDistances(pairs_, begin, end, world_from_camera,
                            options_.inlier_distance_m);
}

geometry::Rigid3 PointSolver::Refitted(
    const geometry::Rigid3& world_from_camera, size_t end) const {
  return geometry::SolveKabsch(SumInliers(pairs_, end, world_from_camera,
                                          options_.inlier_distance_m))
      .value_or(world_from_camera);
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
