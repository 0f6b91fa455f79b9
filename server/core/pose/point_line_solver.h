// Poses from three measured points, judged on points and on lines.
#ifndef SERVER_CORE_POSE_POINT_LINE_SOLVER_H_
#define SERVER_CORE_POSE_POINT_LINE_SOLVER_H_

#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/base/random.h"
#include "common/geometry/rigid3.h"
#include "server/core/pose/minimal_solver.h"
#include "server/core/pose/point_refinement.h"
#include "server/core/pose/point_solver.h"
#include "server/core/pose/scene_predictions.h"

namespace treeline::pose {

struct PointLineSolverOptions {
  PointSolverOptions points;
  // Few survivors are fitted to points and lines (thesis 5.5); more of them,
  // and those that it does not converge for, to points alone.
  PointRefinementOptions refinement;
};

// A MinimalSolver of points on points and points on lines (thesis chapter 5):
// triangles of points, scored by the distance across the line for points that
// lie on one. scene.line_direction_in_camera must be there for every point.
// `scene` must outlive it.
class PointLineSolver {
 public:
  using Model = geometry::Rigid3;  // world_from_camera
  static constexpr uint64_t kStream = PointSolver::kStream;
  static constexpr size_t kMinimum = PointSolver::kMinimum;
  static constexpr int kMaxDraws = PointSolver::kMaxDraws;

  PointLineSolver(const PointPredictions& scene,
                  const PointLineSolverOptions& options);

  size_t size() const { return scene_.size(); }
  std::optional<geometry::Rigid3> Draw(base::Random& random) const;
  double Cost(const geometry::Rigid3& world_from_camera, size_t begin,
              size_t end) const;
  // Takes the refit even where it costs more, as PointSolver does.
  void Improve(Hypothesis<geometry::Rigid3>& hypothesis, size_t seen,
               size_t survivors) const;
  geometry::Rigid3 Finish(const geometry::Rigid3& world_from_camera) const;

 private:
  const PointPredictions& scene_;
  const PointLineSolverOptions options_;
  const PointSolver points_;
  PackedVectors line_direction_;
};

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_POINT_LINE_SOLVER_H_
