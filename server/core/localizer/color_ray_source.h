// The thesis's chapter 4 without depth in queries ("BTBRF, RGB at test"):
// pixels, and a backtracking forest's scene coordinates of them.
#ifndef SERVER_CORE_LOCALIZER_COLOR_RAY_SOURCE_H_
#define SERVER_CORE_LOCALIZER_COLOR_RAY_SOURCE_H_

#include "server/core/forest/forest.h"
#include "server/core/localizer/parameters.h"
#include "server/core/localizer/pose_source.h"
#include "server/core/pose/ray_solver.h"

namespace treeline::localizer {

// A PoseSource, of the colour camera's pose.
class ColorRaySource {
 public:
  using Observations = RayObservations;
  static constexpr uint64_t kRansacStream = kForestRansacStream;
  static constexpr int kMinSamples = kMinForestSamples;
  static constexpr int kMinInliers = 0;
  static constexpr bool kIsMatched = false;

  // `forest` was grown without depth adaptation.
  ColorRaySource(const forest::ForestView& forest, const QueryOptions& options)
      : forest_(&forest), options_(options) {}

  absl::StatusOr<size_t> Observe(Query& query,
                                 std::span<const Candidate> earlier,
                                 RayObservations& seen) const;
  pose::RaySolver Solver(Query& query, const RayObservations& seen) const;
  std::optional<pose::RefinedPose> Refine(
      Query& query, const RayObservations& seen,
      const geometry::Rigid3& world_from_camera) const;
  // Where the points are in the camera is not known: zero.
  std::vector<Correspondence> Explain(
      const RayObservations& seen,
      const std::optional<pose::RefinedPose>& pose) const {
    return CorrespondencesOf(seen, pose);
  }

 private:
  const forest::ForestView* forest_;
  QueryOptions options_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_COLOR_RAY_SOURCE_H_
