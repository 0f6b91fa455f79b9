// How every scene answers, whatever its method: predict, hypotheses, refine,
// verify, report.
#ifndef SERVER_CORE_LOCALIZER_PIPELINE_H_
#define SERVER_CORE_LOCALIZER_PIPELINE_H_

#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "server/core/forest/model_file.h"
#include "server/core/localizer/candidate.h"
#include "server/core/localizer/focal_doubt.h"
#include "server/core/localizer/localizer.h"
#include "server/core/localizer/pool.h"
#include "server/core/localizer/pose_verifier.h"
#include "server/core/localizer/query.h"

namespace treeline::localizer {

// A generator, and what becomes of its candidate.
struct Step {
  std::unique_ptr<const CandidateGenerator> generator;
  // Its candidate is a start for later steps, and verified only where none of
  // them proposes a pose.
  bool is_fallback = false;
  // It is asked only if the pose is expected somewhere
  // (LocalizeOptions::priors) and ends the search only if its pose is believed.
  bool is_shortcut = false;
};

// What becomes of the focal length of a query's camera.
enum class FocalUse {
  kAsStated,
  // It is sought where nobody stated a camera, and corrected where what is seen
  // says clearly that it is wrong.
  kCorrected,
};

// What makes one method differ from another.
struct Method {
  DepthUse depth_use = DepthUse::kIgnored;
  // In the order in which they are asked: cheap ones first. At least one.
  std::vector<Step> steps;
  std::unique_ptr<const PoseVerifier> verifier;
  // What the verifier holds of them; may be null.
  const keyframes::KeyframeMap* keyframes = nullptr;
  // A verified candidate of at least this confidence ends the search, in
  // [0, 1]. 0: the first one does, believed or not.
  double sufficient_confidence = 0;
  // See ConfidenceModel and QueryOptions. nullopt: it was never measured, 1.
  std::optional<double> focal_sigma_scale = std::nullopt;
  FocalUse focal_use = FocalUse::kCorrected;
};

// What the search settled on.
struct Selection {
  Candidate candidate;
  std::optional<Verdict> verdict;  // nullopt: it has no pose
  FocalEvidence focal;             // of all candidates
  // So many times, depth is what is seen: the search ended for it. nullopt: it
  // may well be right as it is.
  std::optional<double> depth_scale;
};

// Asks the steps of `method` one after the other for candidates, verifies them,
// and selects the best by the verifier's evidence; among equals, the earlier.
// A pose that contradicts the query's priors is not believed, and does not end
// the search. Without a pose, the first candidate that had enough to look at
// says why. Where the query's focal length is doubtful, no pose ends the search
// before features have told of it. Where the scale of depth is open and another
// one is found, the search ends there. Errors of the generators; CANCELLED
// after the query's stop.
absl::StatusOr<Selection> SelectCandidate(const Method& method, Query& query);

// Times what the frame states, and by how much features spoke against that.
struct Corrections {
  double focal_scale = 1;
  double depth_scale = 1;
  double focal_error_sigmas = 0;
};

// As SelectCandidate, and asks again with the focal length that is spoken for,
// as long as that answer is good enough (FocalDoubt). Likewise with
// another scale of depth. `corrections` become the selection's, and `query` has
// the cameras that were tried last.
absl::StatusOr<Selection> SelectWithAnyCalibration(const Method& method,
                                                   Query& query,
                                                   Corrections& corrections);

// A model with the method that reads it.
class Pipeline final : public Localizer {
 public:
  // `method` was made from `model`.
  Pipeline(std::unique_ptr<const forest::ModelFile> model, Method method);

  absl::StatusOr<PoseEstimate> Localize(
      const image::Frame& frame, const LocalizeOptions& options) const override;
  const forest::ModelInfo& info() const override { return model_->info(); }
  DepthUse depth_use() const override { return method_.depth_use; }
  const keyframes::KeyframeMap* keyframes() const override {
    return method_.keyframes;
  }

 private:
  struct Found {
    Selection selection;
    Corrections corrections;
    // Of queries of other cameras.
    LocalizeTimings timings;
    // What the lens of a camera that nobody knows had to be corrected by.
    std::optional<pose::LensEstimate> lens = std::nullopt;
  };
  Query Ask(const image::Frame& frame,
            const camera::RgbdCalibration& calibration,
            const LocalizeOptions& options, QueryScratch& scratch) const;
  // Whether what `query`, of another camera than the stated one, finds is to be
  // believed rather than what was found with that. Adds to its timings.
  absl::StatusOr<bool> IsRather(Query query, Found& stated) const;
  // Asks anew with the focal length that was found, where features should have
  // been sought at another resolution than for the one that was assumed.
  absl::Status AskAgainWithFocal(const image::Frame& frame,
                                 const camera::RgbdCalibration& assumed,
                                 const LocalizeOptions& options,
                                 QueryScratch& scratch, Found& found) const;
  // Asks anew with the lens that was found, where that is not the assumed one.
  // The camera that the selection is of.
  absl::StatusOr<camera::Camera> AskAgainWithLens(
      const image::Frame& frame, const camera::RgbdCalibration& assumed,
      const LocalizeOptions& options, QueryScratch& scratch,
      Found& found) const;
  // Whether features of this scene tell what a camera is like, by its trials.
  bool TellsLenses() const;
  // Whether the camera, which nobody stated, is what was seen with.
  bool IsAssumedRightly(const Found& found, const PoseEstimate& estimate) const;
  // What not to know the camera adds to the answer's covariance; zero where it
  // is as stated. nullopt: nothing that is seen tells of it.
  static std::optional<geometry::PoseCovariance> CameraDoubt(
      const Query& query, const Found& found);
  // Whether position and camera are known as well as an answer needs.
  void Weigh(const Query& query, const Found& found,
             PoseEstimate& estimate) const;
  // Puts what was found with one of CentredCameras in the place of `found`,
  // where that is rather to be believed.
  absl::Status TryOtherCameras(const image::Frame& frame,
                               const camera::RgbdCalibration& stated,
                               const LocalizeOptions& options,
                               QueryScratch& scratch, Found& found) const;
  // Asks anew what would have been seen at the frame's time stamp, where the
  // scene's camera took it and turned while it read its rows.
  absl::Status UndoShutter(const image::Frame& frame,
                           const LocalizeOptions& options, Query& query,
                           QueryScratch& scratch, Found& found) const;

  const std::unique_ptr<const forest::ModelFile> model_;
  const Method method_;
  mutable Pool<QueryScratch> scratch_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_PIPELINE_H_
