// Poses from three rays and their predictions.
#ifndef SERVER_CORE_POSE_RAY_SOLVER_H_
#define SERVER_CORE_POSE_RAY_SOLVER_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/random.h"
#include "common/geometry/rigid3.h"
#include "server/core/pose/minimal_solver.h"
#include "server/core/pose/ray_kernels.h"
#include "server/core/pose/scene_predictions.h"
#include "server/core/pose/truncated_cost.h"

namespace treeline::pose {

struct RaySolverOptions {
  // Reprojection errors count in full up to this distance and no further, in
  // units of the ray (pixels over focal length).
  double inlier_distance = 10.0 / 525;
};

// A MinimalSolver of rays (Perspective-n-Point): P3P on three rays, of whose
// poses the one is taken that sees a fourth point nearest to its ray. `scene`
// must outlive it.
class RaySolver {
 public:
  using Model = geometry::Rigid3;  // camera_from_world
  static constexpr uint64_t kStream = 0x706e700000000000;
  static constexpr size_t kMinimum = 4;
  static constexpr int kMaxDraws = 50;

  RaySolver(const RayPredictions& scene, const RaySolverOptions& options);

  size_t size() const { return scene_.size(); }
  std::optional<geometry::Rigid3> Draw(base::Random& random) const;
  // Of the squared reprojection errors of the best predictions.
  double Cost(const geometry::Rigid3& camera_from_world, size_t begin,
              size_t end) const;
  // A few steps of refinement on all rays, for few survivors, where it lowers
  // the cost.
  void Improve(Hypothesis<geometry::Rigid3>& hypothesis, size_t seen,
               size_t survivors) const;
  // world_from_camera.
  geometry::Rigid3 Finish(const geometry::Rigid3& camera_from_world) const;

 private:
  const RayPredictions& scene_;
  const RaySolverOptions options_;
  std::vector<float> u_;
  std::vector<float> v_;
  PackedVectors in_world_;
  PackedRays rays_;
};

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_RAY_SOLVER_H_
