// The stage "verify": what speaks for a pose is gathered, and it is believed or
// not.
#ifndef SERVER_CORE_LOCALIZER_POSE_VERIFIER_H_
#define SERVER_CORE_LOCALIZER_POSE_VERIFIER_H_

#include <optional>

#include "server/core/keyframes/depth_scale.h"
#include "server/core/localizer/candidate.h"
#include "server/core/localizer/localizer.h"
#include "server/core/localizer/query.h"

namespace treeline::localizer {

// The largest standard deviation of the position's axes (m).
double PositionSigma_m(const geometry::PoseCovariance& covariance);

struct Verdict {
  // What speaks against the pose; kNone: it is believed.
  NotLocalizedReason reason = NotLocalizedReason::kNone;
  // The candidate's, or a better one near it.
  geometry::Rigid3 world_from_camera = {};
  geometry::PoseCovariance covariance{};
  // What matched features alone say of it, where nothing but them and what the
  // picture looks like holds the pose; nullopt: something else does.
  std::optional<geometry::PoseCovariance> of_features = std::nullopt;
  // See PoseEstimate.
  double confidence = 0;
  forest::PoseEvidence evidence = {};
  // Where depth refutes the pose, what its confidence would be without depth.
  double picture_confidence = 0;
  // See Alignment; nullopt without depth.
  std::optional<keyframes::DepthScale> depth_scale = std::nullopt;

  bool is_believed() const { return reason == NotLocalizedReason::kNone; }
};

// Whether `a` is the better answer: what is believed, and then what is more
// probable.
bool IsBetter(const Verdict& a, const Verdict& b);

// How many times as large the odds are that `a` is right.
double OddsRatio(const Verdict& a, const Verdict& b);

// Whether one of them has to be wrong.
bool AreApart(const Verdict& a, const Verdict& b);

// What an answer needs.
struct Grounds {
  bool has_enough_inliers = false;
  bool is_determined = false;
  bool fits_depth = true;
  bool is_confident = false;
};

// The first that is missing; kNone if none is.
NotLocalizedReason ReasonAgainst(const Grounds& grounds);

// Immutable and thread-safe. The model that it was made from must outlive it.
class PoseVerifier {
 public:
  virtual ~PoseVerifier() = default;

  // `candidate` has a pose. The same query and candidate give the same verdict.
  virtual Verdict Verify(Query& query, const Candidate& candidate) const = 0;

  // The least confidence of an answer.
  virtual double MinConfidence(const LocalizeOptions& options) const = 0;

  // An answer's position has to be known as well: the largest standard
  // deviation of its axes, in the scene's units.
  virtual double MaxPositionSigma() const = 0;

  // How many times the query's depth is what is seen from about the pose (of
  // the pose sensor), judged by a pose that is the picture's alone. nullopt: it
  // cannot be told.
  virtual std::optional<keyframes::DepthScale> MeasureDepth(
      Query& /*query*/, const geometry::Rigid3& /*world_from_camera*/) const {
    return std::nullopt;
  }
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_POSE_VERIFIER_H_
