// The thesis's chapter 4 outdoors: SIFT features, and their places in the scene
// from a backtracking forest that was trained on a structure from motion.
#ifndef SERVER_CORE_LOCALIZER_SIFT_SOURCE_H_
#define SERVER_CORE_LOCALIZER_SIFT_SOURCE_H_

#include "server/core/forest/forest.h"
#include "server/core/forest/sift_backtracking.h"
#include "server/core/localizer/parameters.h"
#include "server/core/localizer/pose_source.h"
#include "server/core/pose/ray_solver.h"

namespace treeline::localizer {

// A PoseSource, of the colour camera's pose, in the scene's units. Any camera
// and image size will do: features become rays through the frame's own camera.
class SiftSource {
 public:
  using Observations = RayObservations;
  static constexpr uint64_t kRansacStream = kForestRansacStream;
  static constexpr int kMinSamples = kMinSiftMatches;
  static constexpr int kMinInliers = 0;
  static constexpr bool kIsMatched = false;

  // `viewing_distance` is ModelInfo's.
  SiftSource(const forest::ForestView& forest, double viewing_distance,
             const QueryOptions& options)
      : forest_(&forest),
        viewing_distance_(viewing_distance),
        options_(options) {}

  // Features with a place in the scene, surest first.
  absl::StatusOr<size_t> Observe(Query& query,
                                 std::span<const Candidate> earlier,
                                 RayObservations& seen) const;
  pose::RaySolver Solver(Query& query, const RayObservations& seen) const;
  std::optional<pose::RefinedPose> Refine(
      Query& query, const RayObservations& seen,
      const geometry::Rigid3& world_from_camera) const;
  // Points are where the forest says, as seen from the pose.
  std::vector<Correspondence> Explain(
      const RayObservations& seen,
      const std::optional<pose::RefinedPose>& pose) const {
    return MatchesOf(seen, pose);
  }

 private:
  void Append(const features::SiftFeatures& features,
              std::span<const forest::SiftMatch> matches, const Query& query,
              RayObservations& seen) const;

  const forest::ForestView* forest_;
  double viewing_distance_;
  QueryOptions options_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_SIFT_SOURCE_H_
