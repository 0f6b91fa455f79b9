// How predictions become a candidate, whatever is predicted: the stages
// predict, hypotheses and refine.
#ifndef SERVER_CORE_LOCALIZER_POSE_SOURCE_H_
#define SERVER_CORE_LOCALIZER_POSE_SOURCE_H_

#include <algorithm>
#include <concepts>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "common/geometry/rigid3.h"
#include "server/core/localizer/candidate.h"
#include "server/core/localizer/query.h"
#include "server/core/localizer/query_options.h"
#include "server/core/pose/focal_estimate.h"
#include "server/core/pose/minimal_solver.h"
#include "server/core/pose/preemptive_ransac.h"
#include "server/core/pose/robust_refinement.h"
#include "server/core/pose/scene_predictions.h"

namespace treeline::localizer {

// Samples with depth, in random order.
struct PointObservations {
  pose::PointPredictions scene;
  std::vector<camera::Pixel> pixel;  // of the colour image

  size_t size() const { return scene.size(); }
};

// Samples without depth, in random order or surest first.
struct RayObservations {
  pose::RayPredictions scene;
  std::vector<camera::Pixel> pixel;

  size_t size() const { return scene.size(); }
};

// The correspondences of the samples: with the prediction that supports the
// pose, or else the best one. Of rays, point_in_camera is not known, and zero.
std::vector<Correspondence> CorrespondencesOf(
    const PointObservations& seen,
    const std::optional<pose::RefinedPose>& pose);
std::vector<Correspondence> CorrespondencesOf(
    const RayObservations& seen, const std::optional<pose::RefinedPose>& pose);

// Those of matched features, which have one prediction each. Points in the
// camera are the predictions as seen from the pose; zero if there is none.
std::vector<Correspondence> MatchesOf(
    const RayObservations& seen, const std::optional<pose::RefinedPose>& pose);

// At how many places of the picture features support the pose, each at least
// `apart_px` from the others; counts no further than `enough`. Several features
// at one place (of several sizes and angles) are right or wrong together.
int CountPlaces(const RayObservations& seen, const pose::RefinedPose& pose,
                double apart_px, int enough);

// See Candidate::lens; nullopt where the stated camera is no guess.
std::optional<AssumedLens> LensOf(const Query& query,
                                  const pose::RayPredictions& scene,
                                  const pose::RefinedPose& pose,
                                  double robust_scale);

// What a method sees in a frame, where in the scene it takes it to be, and how
// that gives a pose.
//
//   kRansacStream  Stream of RANSAC's seed.
//   kMinSamples    Fewer say nothing.
//   kMinInliers    A pose that fewer support is not proposed.
//   kIsMatched     See Candidate::is_matched.
//   Observe        Stage "predict": appends the next samples with their
//                  predictions. Returns how many samples the frame gives in
//                  all; nothing is appended where those are too few.
//   Solver         What RANSAC works with.
//   Refine         Stage "refine".
//   Explain        The correspondences.
//   Focal, Lens, DistinctShare  See Candidate. May be left out.
template <typename S>
concept PoseSource = requires(const S& source, Query& query,
                              std::span<const Candidate> earlier,
                              typename S::Observations& seen,
                              const geometry::Rigid3& pose,
                              const std::optional<pose::RefinedPose>& refined) {
  { S::kRansacStream } -> std::convertible_to<uint64_t>;
  { S::kMinSamples } -> std::convertible_to<int>;
  { S::kMinInliers } -> std::convertible_to<int>;
  { S::kIsMatched } -> std::convertible_to<bool>;
  {
    source.Observe(query, earlier, seen)
    } -> std::same_as<absl::StatusOr<size_t>>;
  { source.Solver(query, seen) } -> pose::MinimalSolver;
  {
    source.Refine(query, seen, pose)
    } -> std::same_as<std::optional<pose::RefinedPose>>;
  {
    source.Explain(seen, refined)
    } -> std::same_as<std::vector<Correspondence>>;
};

// Asks a source for samples until enough of them support a pose.
template <PoseSource Source>
class SourceGenerator final : public CandidateGenerator {
 public:
  SourceGenerator(Source source, const QueryOptions& options)
      : source_(std::move(source)), options_(options) {}

  absl::StatusOr<Candidate> Propose(
      Query& query, std::span<const Candidate> earlier) const override {
    Candidate candidate;
    candidate.is_matched = Source::kIsMatched;
    typename Source::Observations seen;
    size_t available = 0;
    do {
      TL_ASSIGN_OR_RETURN(available, source_.Observe(query, earlier, seen));
      candidate.samples = static_cast<int>(available);
      if (candidate.samples < Source::kMinSamples) return candidate;
      candidate.pose = Solve(query, seen);
      TL_RETURN_IF_ERROR(query.CheckStop());
    } while (seen.size() < available && !IsSettled(candidate));
    candidate.samples = static_cast<int>(seen.size());
    candidate.reason = NotLocalizedReason::kTooFewInliers;
    if (candidate.pose && candidate.pose->inliers < Source::kMinInliers) {
      candidate.pose.reset();
    }
    if (candidate.pose) {
      if constexpr (requires { &Source::Focal; }) {
        candidate.focal = source_.Focal(query, seen, *candidate.pose);
      }
      if constexpr (requires { &Source::Lens; }) {
        candidate.lens = source_.Lens(query, seen, *candidate.pose);
      }
      if constexpr (requires { &Source::DistinctShare; }) {
        candidate.distinct =
            source_.DistinctShare(query, seen, *candidate.pose);
      }
    }
    if (query.options().keep_correspondences) {
      candidate.correspondences = source_.Explain(seen, candidate.pose);
    }
    return candidate;
  }

 private:
  std::optional<pose::RefinedPose> Solve(
      Query& query, const typename Source::Observations& seen) const {
    const pose::RansacOptions ransac{
        .seed = base::MixBits(query.seed() + Source::kRansacStream),
        .hypotheses = options_.hypotheses};
    const std::optional<geometry::Rigid3> pose = pose::PreemptiveRansac(
        source_.Solver(query, seen), ransac, query.stop());
    if (!pose) return std::nullopt;
    return source_.Refine(query, seen, *pose);
  }

  bool IsSettled(const Candidate& candidate) const {
    return candidate.pose &&
           candidate.pose->inliers >= options_.settled_inliers;
  }

  const Source source_;
  const QueryOptions options_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_POSE_SOURCE_H_
