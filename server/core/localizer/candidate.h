// A pose that may be the answer, and who proposes such.
#ifndef SERVER_CORE_LOCALIZER_CANDIDATE_H_
#define SERVER_CORE_LOCALIZER_CANDIDATE_H_

#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "server/core/localizer/assumed_lens.h"
#include "server/core/localizer/localizer.h"
#include "server/core/localizer/query.h"
#include "server/core/pose/focal_estimate.h"
#include "server/core/pose/robust_refinement.h"

namespace treeline::localizer {

struct Candidate {
  // Of the scene's pose sensor. nullopt: nothing explains what was seen.
  std::optional<pose::RefinedPose> pose;
  // Why there is none.
  NotLocalizedReason reason = NotLocalizedReason::kTooFewSamples;
  // What the pose was sought with.
  int samples = 0;
  // They are features that were matched one by one, not a forest's predictions
  // of what is about them.
  bool is_matched = false;
  // What it was sought with says of the focal length that the query states:
  // matched features, or measured points of the colour camera.
  std::optional<pose::FocalEstimate> focal;
  // Of matched features, where no camera is stated, or a guess.
  std::optional<AssumedLens> lens;
  // Of the features that support the pose, the share that is like nothing
  // elsewhere in the scene, in [0, 1]; see CountDistinct.
  double distinct = 1;
  // At how many places of the picture features support the pose, at most
  // kEnoughSiftPlaces; see CountPlaces. 0: not counted.
  int places = 0;
  // Filled if the query asks for it.
  std::vector<Correspondence> correspondences;

  // Share of the samples that support the pose, in [0, 1].
  double inlier_ratio() const {
    return pose ? static_cast<double>(pose->inliers) / samples : 0;
  }
};

// Immutable and thread-safe; the model that it was made from must outlive it.
class CandidateGenerator {
 public:
  virtual ~CandidateGenerator() = default;

  // `earlier` are the candidates of the generators that were asked before, in
  // their order. The same query gives the same candidate. To find none is OK;
  // errors are CANCELLED, and INTERNAL where a library fails.
  virtual absl::StatusOr<Candidate> Propose(
      Query& query, std::span<const Candidate> earlier) const = 0;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_CANDIDATE_H_
