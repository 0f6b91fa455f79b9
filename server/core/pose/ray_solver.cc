#include "server/core/pose/ray_solver.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/core/pose/p3p.h"
#include "server/core/pose/parameters.h"
#include "server/core/pose/ray_refinement.h"
#include "server/core/pose/reprojection.h"

namespace treeline::pose {
namespace {

// Whether three rays are at least this far apart.
bool AreSpread(const std::array<camera::Pixel, 4>& ray, double min_side) {
  for (size_t a = 0; a < 3; ++a) {
    const camera::Pixel& p = ray[a];
    const camera::Pixel& q = ray[(a + 1) % 3];
    if (!(std::hypot(p.x - q.x, p.y - q.y) >= min_side)) return false;
  }
  return true;
}

}  // namespace

RaySolver::RaySolver(const RayPredictions& scene,
                     const RaySolverOptions& options)
    : scene_(scene), options_(options), rays_(scene) {
  for (size_t i = 0; i < scene.size(); ++i) {
    u_.push_back(static_cast<float>(scene.ray[i].x));
    v_.push_back(static_cast<float>(scene.ray[i].y));
    in_world_.Add(scene.at(i, 0).mean_in_world);
  }
}

std::optional<geometry::Rigid3> RaySolver::Draw(base::Random& random) const {
  const uint32_t n = static_cast<uint32_t>(scene_.size());
  std::array<camera::Pixel, 4> ray;
  std::array<geometry::Vec3, 4> point;
  for (size_t k = 0; k < 4; ++k) {
    const size_t i = random.NextBelow(n);
    ray[k] = scene_.ray[i];
    point[k] = scene_.at(i, 0).mean_in_world;
  }
  if (!AreSpread(ray, kMinRaySide * options_.inlier_distance)) {
    return std::nullopt;
  }
  const P3pSolutions solutions =
      SolveP3p({ray[0], ray[1], ray[2]}, {point[0], point[1], point[2]});
  double best = options_.inlier_distance * options_.inlier_distance;
  std::optional<geometry::Rigid3> pose;
  for (int s = 0; s < solutions.count; ++s) {
    const geometry::Rigid3& candidate =
        solutions.camera_from_world[static_cast<size_t>(s)];
    const double error =
        SquaredReprojectionError(CameraFromWorld(candidate), point[3], ray[3]);
    if (error < best) {
      best = error;
      pose = candidate;
    }
  }
  return pose;
}

double RaySolver::Cost(const geometry::Rigid3& camera_from_world, size_t begin,
                       size_t end) const {
  const FloatTransform p(camera_from_world);
  const float* const x = in_world_.x.data();
  const float* const y = in_world_.y.data();
  const float* const z = in_world_.z.data();
  const float* const u = u_.data();
  const float* const v = v_.data();
  return TruncatedCost(begin, end, options_.inlier_distance, [&](size_t i) {
    const float px = p.m[0] * x[i] + p.m[1] * y[i] + p.m[2] * z[i] + p.tx;
    const float py = p.m[3] * x[i] + p.m[4] * y[i] + p.m[5] * z[i] + p.ty;
    const float pz = p.m[6] * x[i] + p.m[7] * y[i] + p.m[8] * z[i] + p.tz;
    const float safe_z = std::max(pz, static_cast<float>(kMinPointDepth));
    const float du = px / safe_z - u[i];
    const float dv = py / safe_z - v[i];
    return du * du + dv * dv;
  });
}

void RaySolver::Improve(Hypothesis<geometry::Rigid3>& hypothesis, size_t seen,
                        size_t survivors) const {
  if (survivors > static_cast<size_t>(kMaxRefinedRayPoses)) return;
  const std::optional<geometry::Rigid3> refined =
      RefineOnBestPredictions(rays_, hypothesis.model.Inverse(),
                              options_.inlier_distance, kLocalRayIterations);
  if (!refined) return;
  const geometry::Rigid3 camera_from_world = refined->Inverse();
  const double cost = Cost(camera_from_world, 0, seen);
  if (cost < hypothesis.cost) hypothesis = {camera_from_world, cost};
}

geometry::Rigid3 RaySolver::Finish(
    const geometry::Rigid3& camera_from_world) const {
  return camera_from_world.Inverse();
}

}  // namespace treeline::pose
