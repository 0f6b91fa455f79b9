// The thesis's chapter 4 outdoors: SIFT features, and their places in the scene
// from a backtracking forest that was trained on a structure from motion.
#ifndef SERVER_CORE_LOCALIZER_SIFT_GENERATOR_H_
#define SERVER_CORE_LOCALIZER_SIFT_GENERATOR_H_

#include <optional>
#include <span>
#include <vector>

#include "server/core/features/sift_features.h"
#include "server/core/forest/forest.h"
#include "server/core/forest/sift_backtracking.h"
#include "server/core/forest/sift_places.h"
#include "server/core/localizer/candidate.h"
#include "server/core/localizer/parameters.h"
#include "server/core/localizer/pose_source.h"
#include "server/core/localizer/query_options.h"

namespace treeline::localizer {

// Proposes the colour camera's pose, in the scene's units. Any camera and image
// size will do: features become rays through the frame's own camera.
//
// The forest is asked about some of the features first. If so many agree that
// their pose is beyond doubt, the pose says where to look for the others: among
// the modes of the places that it shows near them. If not, the forest is asked
// about all.
class SiftGenerator final : public CandidateGenerator {
 public:
  // `viewing_distance` is ModelInfo's.
  SiftGenerator(const forest::ForestView& forest, double viewing_distance,
                const QueryOptions& options);

  absl::StatusOr<Candidate> Propose(
      Query& query, std::span<const Candidate> earlier) const override;

 private:
  // A frame's features, and what is known of them: slot i of each array.
  struct Features {
    features::SiftFeatures found;
    std::vector<camera::Pixel> ray;  // (x/z, y/z)
    std::vector<forest::SiftMatch> match;

    size_t size() const { return ray.size(); }
    // Squared ratio of distances: what is least like anything else is surest.
    double Ratio(size_t i) const;
    bool IsMatched(size_t i) const;
  };

  Features Extract(Query& query) const;
  // About every step-th feature, which visits so many leaves of each tree.
  void AskForest(size_t step, int leaves, Query& query,
                 Features& features) const;
  // Features with a place in the scene, surest first.
  RayObservations Observe(const Features& features, Query& query) const;
  std::optional<pose::RefinedPose> Solve(const RayObservations& seen,
                                         Query& query) const;
  std::optional<pose::RefinedPose> Refine(
      const RayObservations& seen, const geometry::Rigid3& world_from_camera,
      Query& query) const;
  // From some features, and by their pose from the others. nullopt: there is
  // none beyond doubt.
  std::optional<pose::RefinedPose> SolveGuided(Query& query, Features& features,
                                               RayObservations& seen) const;

  const forest::ForestView& forest_;
  const forest::SiftPlaces places_;
  const double viewing_distance_;
  const QueryOptions options_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_SIFT_GENERATOR_H_
