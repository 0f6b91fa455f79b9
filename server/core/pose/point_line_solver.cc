#include "server/core/pose/point_line_solver.h"

#include <algorithm>

#include "server/core/pose/parameters.h"

namespace treeline::pose {

PointLineSolver::PointLineSolver(const PointPredictions& scene,
                                 const PointLineSolverOptions& options)
    : scene_(scene), options_(options), points_(scene, options.points) {
  for (const geometry::Vec3& direction : scene.line_direction_in_camera) {
    line_direction_.Add(direction);
  }
}

std::optional<geometry::Rigid3> PointLineSolver::Draw(
    base::Random& random) const {
  return points_.Draw(random);
}

double PointLineSolver::Cost(const geometry::Rigid3& world_from_camera,
                             size_t begin, size_t end) const {
  const FloatTransform p(world_from_camera);
  const PackedVectors& camera = points_.points_in_camera();
  const PackedVectors& world = points_.best_in_world();
  const float* const cx = camera.x.data();
  const float* const cy = camera.y.data();
  const float* const cz = camera.z.data();
  const float* const wx = world.x.data();
  const float* const wy = world.y.data();
  const float* const wz = world.z.data();
  const float* const lx = line_direction_.x.data();
  const float* const ly = line_direction_.y.data();
  const float* const lz = line_direction_.z.data();
  constexpr float kMaxSlide2_m2 =
      static_cast<float>(kMaxScoredSlide_m * kMaxScoredSlide_m);
  return TruncatedCost(
      begin, end, options_.points.inlier_distance_m, [&](size_t i) {
        const float dx =
            p.m[0] * cx[i] + p.m[1] * cy[i] + p.m[2] * cz[i] + p.tx - wx[i];
        const float dy =
            p.m[3] * cx[i] + p.m[4] * cy[i] + p.m[5] * cz[i] + p.ty - wy[i];
        const float dz =
            p.m[6] * cx[i] + p.m[7] * cy[i] + p.m[8] * cz[i] + p.tz - wz[i];
        const float along =
            dx * (p.m[0] * lx[i] + p.m[1] * ly[i] + p.m[2] * lz[i]) +
            dy * (p.m[3] * lx[i] + p.m[4] * ly[i] + p.m[5] * lz[i]) +
            dz * (p.m[6] * lx[i] + p.m[7] * ly[i] + p.m[8] * lz[i]);
        return std::max(0.0f, dx * dx + dy * dy + dz * dz -
                                  std::min(along * along, kMaxSlide2_m2));
      });
}

void PointLineSolver::Improve(Hypothesis<geometry::Rigid3>& hypothesis,
                              size_t seen, size_t survivors) const {
  std::optional<RefinedPose> refined;
  if (survivors <= static_cast<size_t>(kMaxRefinedPointLinePoses)) {
    PointRefinementOptions refinement = options_.refinement;
    refinement.max_points = seen;
    refined = RefinePoints(scene_, hypothesis.model, refinement);
  }
  hypothesis.model = refined ? refined->world_from_camera
                             : points_.Refitted(hypothesis.model, seen);
  hypothesis.cost = Cost(hypothesis.model, 0, seen);
}

geometry::Rigid3 PointLineSolver::Finish(
    const geometry::Rigid3& world_from_camera) const {
  return world_from_camera;
}

}  // namespace treeline::pose
