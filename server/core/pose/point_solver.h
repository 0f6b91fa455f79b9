// Poses from three measured points and their predictions.
#ifndef SERVER_CORE_POSE_POINT_SOLVER_H_
#define SERVER_CORE_POSE_POINT_SOLVER_H_

#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/base/random.h"
#include "common/geometry/rigid3.h"
#include "server/core/pose/minimal_solver.h"
#include "server/core/pose/point_kernels.h"
#include "server/core/pose/scene_predictions.h"
#include "server/core/pose/truncated_cost.h"

namespace treeline::pose {

struct PointSolverOptions {
  // Residuals count in full up to this distance and no further (m).
  double inlier_distance_m = 0.1;
  // The three points of a hypothesis are at least this far apart (m), ...
  double min_side_m = 0.25;
  // ... and the sides of their triangle agree with those of their predictions
  // this well (m).
  double side_tolerance_m = 0.06;
};

// A MinimalSolver of points on points (thesis 4.2.5): Kabsch's algorithm on
// triangles whose sides agree, and again on the inliers of every survivor.
// `scene` must outlive it.
class PointSolver {
 public:
  using Model = geometry::Rigid3;  // world_from_camera
  static constexpr uint64_t kStream = 0x7270000000000000;
  static constexpr size_t kMinimum = 3;
  static constexpr int kMaxDraws = 100;

  PointSolver(const PointPredictions& scene, const PointSolverOptions& options);

  size_t size() const { return scene_.size(); }
  std::optional<geometry::Rigid3> Draw(base::Random& random) const;
  // Of the squared distances to the best predictions.
  double Cost(const geometry::Rigid3& world_from_camera, size_t begin,
              size_t end) const;
  // Takes the refit even where it costs more: it stands on more points than
  // the model did.
  void Improve(Hypothesis<geometry::Rigid3>& hypothesis, size_t seen,
               size_t survivors) const;
  // Refitted to its inliers among all points.
  geometry::Rigid3 Finish(const geometry::Rigid3& world_from_camera) const;

  // Kabsch on the inliers among points [0, end); the pose as it was if they
  // determine none.
  geometry::Rigid3 Refitted(const geometry::Rigid3& world_from_camera,
                            size_t end) const;

  const PackedVectors& points_in_camera() const { return pairs_.in_camera; }
  const PackedVectors& best_in_world() const { return pairs_.in_world; }

 private:
  const PointPredictions& scene_;
  const PointSolverOptions options_;
  PackedPairs pairs_;
};

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_POINT_SOLVER_H_
