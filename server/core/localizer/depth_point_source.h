// The thesis's chapter 4 on RGB-D frames: pixels with depth, and a backtracking
// forest's scene coordinates of them.
#ifndef SERVER_CORE_LOCALIZER_DEPTH_POINT_SOURCE_H_
#define SERVER_CORE_LOCALIZER_DEPTH_POINT_SOURCE_H_

#include "server/core/forest/forest.h"
#include "server/core/localizer/parameters.h"
#include "server/core/localizer/pose_source.h"
#include "server/core/pose/point_solver.h"

namespace treeline::localizer {

// A PoseSource. Needs depth.
class DepthPointSource {
 public:
  using Observations = PointObservations;
  static constexpr uint64_t kRansacStream = kForestRansacStream;
  static constexpr int kMinSamples = kMinForestSamples;
  static constexpr int kMinInliers = 0;
  static constexpr bool kIsMatched = false;

  DepthPointSource(const forest::ForestView& forest,
                   const QueryOptions& options)
      : forest_(&forest), options_(options) {}

  absl::StatusOr<size_t> Observe(Query& query,
                                 std::span<const Candidate> earlier,
                                 PointObservations& seen) const;
  pose::PointSolver Solver(Query& query, const PointObservations& seen) const;
  std::optional<pose::RefinedPose> Refine(
      Query& query, const PointObservations& seen,
      const geometry::Rigid3& world_from_camera) const;
  // nullopt, too, where another camera measures than that of the picture.
  std::optional<pose::FocalEstimate> Focal(Query& query,
                                           const PointObservations& seen,
                                           const pose::RefinedPose& pose) const;
  std::vector<Correspondence> Explain(
      const PointObservations& seen,
      const std::optional<pose::RefinedPose>& pose) const {
    return CorrespondencesOf(seen, pose);
  }

 private:
  const forest::ForestView* forest_;
  QueryOptions options_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_DEPTH_POINT_SOURCE_H_
