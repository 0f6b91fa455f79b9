// The thesis's chapter 5: pixels of the whole image and of its line segments, a
// forest's scene coordinates for each kind, and a pose of points on points and
// points on lines together.
#ifndef SERVER_CORE_LOCALIZER_POINT_LINE_SOURCE_H_
#define SERVER_CORE_LOCALIZER_POINT_LINE_SOURCE_H_

#include "server/core/forest/forest.h"
#include "server/core/localizer/parameters.h"
#include "server/core/localizer/pose_source.h"
#include "server/core/pose/point_line_solver.h"

namespace treeline::localizer {

// A PoseSource. Needs depth. Without line segments in the frame, general points
// alone decide.
class PointLineSource {
 public:
  using Observations = PointObservations;
  static constexpr uint64_t kRansacStream = kForestRansacStream;
  static constexpr int kMinSamples = kMinForestSamples;
  static constexpr int kMinInliers = 0;
  static constexpr bool kIsMatched = false;

  // Forests of as many trees each.
  PointLineSource(const forest::ForestView& points,
                  const forest::ForestView& lines, const QueryOptions& options)
      : point_forest_(&points), line_forest_(&lines), options_(options) {}

  // All samples at once: those on lines are at most half of them.
  absl::StatusOr<size_t> Observe(Query& query,
                                 std::span<const Candidate> earlier,
                                 PointObservations& seen) const;
  pose::PointLineSolver Solver(Query& query,
                               const PointObservations& seen) const;
  std::optional<pose::RefinedPose> Refine(
      Query& query, const PointObservations& seen,
      const geometry::Rigid3& world_from_camera) const;
  std::vector<Correspondence> Explain(
      const PointObservations& seen,
      const std::optional<pose::RefinedPose>& pose) const {
    return CorrespondencesOf(seen, pose);
  }

 private:
  // Into scratch.line_points and scratch.samples.
  void Sample(Query& query) const;

  const forest::ForestView* point_forest_;
  const forest::ForestView* line_forest_;
  QueryOptions options_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_POINT_LINE_SOURCE_H_
