// The thesis's chapter 3 (Algorithm 1): SIFT features of a frame, and those of
// some keyframes that they match.
#ifndef SERVER_CORE_LOCALIZER_KEYFRAME_SOURCE_H_
#define SERVER_CORE_LOCALIZER_KEYFRAME_SOURCE_H_

#include <vector>

#include "server/core/keyframes/keyframe_features.h"
#include "server/core/keyframes/keyframe_map.h"
#include "server/core/localizer/parameters.h"
#include "server/core/localizer/pose_source.h"
#include "server/core/pose/ray_solver.h"

namespace treeline::localizer {

// Which keyframes a frame is matched with.
enum class KeyframeChoice {
  kNearPose,     // those near the last earlier candidate's pose; without, none
  kNearPriors,   // of those near where the pose is expected, the most similar
  kMostSimilar,  // those that share most features with the frame
};

struct KeyframeObservations : RayObservations {
  std::vector<keyframes::KeyframeMatch> match;
};

// A PoseSource, of the colour camera's pose.
class KeyframeSource {
 public:
  using Observations = KeyframeObservations;
  static constexpr uint64_t kRansacStream = kKeyframeRansacStream;
  static constexpr int kMinSamples = kMinKeyframeMatches;
  static constexpr int kMinInliers = kMinKeyframeInliers;
  static constexpr bool kIsMatched = true;

  // A frame is matched with up to `count` keyframes.
  KeyframeSource(const keyframes::KeyframeMap& map, KeyframeChoice choice,
                 int count)
      : map_(&map), choice_(choice), count_(count) {}

  absl::StatusOr<size_t> Observe(Query& query,
                                 std::span<const Candidate> earlier,
                                 KeyframeObservations& seen) const;
  pose::RaySolver Solver(Query& query, const KeyframeObservations& seen) const;
  std::optional<pose::RefinedPose> Refine(
      Query& query, const KeyframeObservations& seen,
      const geometry::Rigid3& world_from_camera) const;
  std::optional<pose::FocalEstimate> Focal(
      Query& query, const KeyframeObservations& seen,
      const pose::RefinedPose& pose) const {
    return pose::EstimateFocal(seen.scene, pose.world_from_camera,
                               RobustScale(query));
  }
  std::optional<AssumedLens> Lens(Query& query,
                                  const KeyframeObservations& seen,
                                  const pose::RefinedPose& pose) const {
    return LensOf(query, seen.scene, pose, RobustScale(query));
  }
  static double RobustScale(const Query& query) {
    return kKeyframeRobustScale_px * query.pixel();
  }
  // See Candidate::distinct.
  double DistinctShare(Query& query, const KeyframeObservations& seen,
                       const pose::RefinedPose& pose) const;
  // Points are where the keyframes say, as seen from the pose.
  std::vector<Correspondence> Explain(
      const KeyframeObservations& seen,
      const std::optional<pose::RefinedPose>& pose) const {
    return MatchesOf(seen, pose);
  }

 private:
  std::vector<size_t> Choose(Query& query,
                             const features::SiftFeatures& features,
                             std::span<const Candidate> earlier) const;

  const keyframes::KeyframeMap* map_;
  KeyframeChoice choice_;
  int count_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_KEYFRAME_SOURCE_H_
