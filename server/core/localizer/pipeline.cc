#include "server/core/localizer/pipeline.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "common/camera/derived_camera.h"
#include "server/core/localizer/assumed_lens.h"
#include "server/core/localizer/parameters.h"
#include "server/core/localizer/position_doubt.h"
#include "server/core/localizer/report.h"
#include "server/core/localizer/shutter_correction.h"
#include "server/core/localizer/stated_camera.h"

namespace treeline::localizer {
namespace {

// The candidates that were proposed, and the best of those verified.
class Search {
 public:
  Search(const PoseVerifier& verifier, Query& query)
      : verifier_(verifier), query_(query) {}

  absl::Status Ask(const CandidateGenerator& generator) {
    TL_RETURN_IF_ERROR(query_.CheckStop());
    TL_ASSIGN_OR_RETURN(Candidate candidate,
                        generator.Propose(query_, candidates_));
    candidates_.push_back(std::move(candidate));
    return absl::OkStatus();
  }

  // Whether the candidate has a pose; one without is passed over.
  bool Verify(size_t i) {
    if (!candidates_[i].pose) return false;
    const StageTimer timer(query_.timings().verify_ms);
    Verdict verdict = verifier_.Verify(query_, candidates_[i]);
    last_ = verdict;
    if (verdict.reason == NotLocalizedReason::kContradictsDepth &&
        (!refuted_ ||
         verdict.picture_confidence > refuted_->picture_confidence)) {
      refuted_ = verdict;
    }
    if (verdict.is_believed() &&
        !query_.options().priors.Allows(verdict.world_from_camera)) {
      verdict.reason = NotLocalizedReason::kContradictsPrior;
    }
    if (verdict_ && !IsBetter(verdict, *verdict_)) return true;
    verdict_ = verdict;
    best_ = i;
    return true;
  }
  bool VerifyLast() { return Verify(candidates_.size() - 1); }
  void VerifyAll() {
    for (size_t i = 0; i < candidates_.size(); ++i) Verify(i);
  }
  // As if it had not been asked for.
  void DropLast() { candidates_.pop_back(); }

  // Whether the last candidate is the best, and believed.
  bool LastIsBelieved() const {
    return verdict_ && best_ + 1 == candidates_.size() &&
           verdict_->is_believed();
  }
  bool IsSatisfied(double sufficient_confidence) const {
    if (!verdict_ || verdict_->confidence < sufficient_confidence ||
        verdict_->reason == NotLocalizedReason::kContradictsPrior) {
      return false;
    }
    const forest::PoseEvidence& evidence = verdict_->evidence;
    return sufficient_confidence == 0 ||
           (evidence.sigma_m <= kSufficientSigma_m &&
            (evidence.matches == 0 || evidence.matches >= kSufficientMatches));
  }
  // Whether the pose that was verified last, however sure, is one that depth of
  // another scale could have led astray.
  bool SuspectsDepth() const {
    return last_ && last_->depth_scale &&
           (std::abs(std::log(last_->depth_scale->scale)) >=
                kSuspectDepthScale ||
            (last_->evidence.depth_agreement < kSureDepthAgreement &&
             last_->evidence.agreement < kSureAgreement));
  }
  bool LastIsMatched() const { return candidates_.back().is_matched; }
  // What depth has to be taken times, by the last candidate's pose; 1: it may
  // well be right. nullopt: nothing explains it.
  std::optional<double> DepthScale() const {
    const StageTimer timer(query_.timings().verify_ms);
    const std::optional<keyframes::DepthScale> measured =
        verifier_.MeasureDepth(query_,
                               candidates_.back().pose->world_from_camera);
    if (!measured || measured->agreement < kMinScaleAgreement) {
      return std::nullopt;
    }
    const double error = std::abs(std::log(measured->scale));
    return error < kMinDepthScaleError ||
                   error < kMinDepthScaleSigmas * measured->sigma
               ? 1
               : measured->scale;
  }
  // Few features are no reason to doubt a focal length that is no guess.
  FocalEvidence Focal() const {
    FocalEvidence evidence;
    const Candidate* most = nullptr;
    for (const Candidate& candidate : candidates_) {
      if (!candidate.focal) continue;
      if (!candidate.is_matched) {
        evidence.points = candidate.focal;
        continue;
      }
      if (most && candidate.pose->inliers <= most->pose->inliers) continue;
      most = &candidate;
    }
    if (most && (query_.is_focal_doubtful() ||
                 most->pose->inliers >= kSufficientMatches)) {
      evidence.features = most->focal;
      evidence.lens = most->lens;
    }
    return evidence;
  }
  // Whether features have to tell of the focal length, and have not yet.
  bool DoubtsFocal() const {
    const FocalEvidence focal = Focal();
    return !focal.features &&
           (query_.is_focal_doubtful() ||
            (focal.points && localizer::DoubtsFocal(*focal.points)));
  }
  Selection Take() && {
    const FocalEvidence focal = Focal();
    if (PictureContradicts()) {
      verdict_->reason = NotLocalizedReason::kContradictsDepth;
    }
    if (!verdict_) best_ = MostTelling();
    return {std::move(candidates_[best_]), verdict_, focal, std::nullopt};
  }
  Selection TakeScaled(double depth_scale) && {
    Selection selection = std::move(*this).Take();
    selection.depth_scale = depth_scale;
    return selection;
  }

 private:
  // Whether the picture is rather of another place than that of the answer, and
  // depth alone refutes that place: one of the two is not of this view.
  bool PictureContradicts() const {
    return verdict_ && verdict_->is_believed() && refuted_ &&
           refuted_->picture_confidence > verdict_->confidence &&
           AreApart(*refuted_, *verdict_);
  }
  // The first that had enough to look at; else the first.
  size_t MostTelling() const {
    for (size_t i = 0; i < candidates_.size(); ++i) {
      if (candidates_[i].reason != NotLocalizedReason::kTooFewSamples) return i;
    }
    return 0;
  }

  const PoseVerifier& verifier_;
  Query& query_;
  std::vector<Candidate> candidates_;
  size_t best_ = 0;
  std::optional<Verdict> verdict_;
  std::optional<Verdict> last_;
  // Of those that depth refutes, the one that the picture speaks for most.
  std::optional<Verdict> refuted_;
};

// With a focal length that is wrong, depth that is right would seem to be
// wrong.
bool IsFocalKnown(const Query& query, const FocalEvidence& focal) {
  return !query.is_focal_doubtful() ||
         IsGuessConfirmed(focal, kMaxKnownFocalSigma);
}

// Depth that is registered to colour has the same camera.
camera::RgbdCalibration WithColor(camera::RgbdCalibration calibration,
                                  const camera::Camera& color) {
  if (calibration.depth == calibration.color) calibration.depth = color;
  calibration.color = color;
  return calibration;
}

// With the colour camera's focal length times `scale`.
absl::StatusOr<camera::RgbdCalibration> WithFocal(
    const camera::RgbdCalibration& calibration, double scale) {
  TL_ASSIGN_OR_RETURN(const camera::Camera color,
                      camera::WithFocalScaled(calibration.color, scale));
  return WithColor(calibration, color);
}

bool IsSure(const Selection& selection, const Method& method) {
  return selection.verdict && selection.verdict->is_believed() &&
         selection.verdict->confidence >= method.sufficient_confidence;
}

// Asks again with the scale of depth that the search speaks for, as long as it
// speaks for another one. `depth_scale` is multiplied with the selection's. A
// scale is one more way to explain what is not of the scene: if what is found
// with it is not sure, depth stays as it is stated.
absl::StatusOr<Selection> SelectWithAnyDepth(const Method& method, Query& query,
                                             double& depth_scale) {
  const camera::RgbdCalibration stated = query.calibration();
  double scale = 1;
  for (int round = 0;; ++round) {
    if (round == kMaxDepthRounds) query.set_depth_scale_open(false);
    TL_ASSIGN_OR_RETURN(Selection selection, SelectCandidate(method, query));
    if (!selection.depth_scale && (scale == 1 || IsSure(selection, method))) {
      depth_scale *= scale;
      return selection;
    }
    if (!selection.depth_scale) query.set_depth_scale_open(false);
    scale = selection.depth_scale ? scale * *selection.depth_scale : 1;
    camera::RgbdCalibration corrected = stated;
    corrected.depth_scale *= scale;
    query.set_calibration(std::move(corrected));
  }
}

}  // namespace

absl::StatusOr<Selection> SelectCandidate(const Method& method, Query& query) {
  Search search(*method.verifier, query);
  bool needs_fallback = true;
  for (const Step& step : method.steps) {
    if (step.is_shortcut && query.options().priors.empty()) continue;
    TL_RETURN_IF_ERROR(search.Ask(*step.generator));
    if (step.is_fallback) continue;
    const bool has_pose = search.VerifyLast();
    bool doubts_depth =
        has_pose && query.is_depth_scale_open() && search.SuspectsDepth();
    if (doubts_depth && search.LastIsMatched() &&
        IsFocalKnown(query, search.Focal())) {
      const std::optional<double> scale = search.DepthScale();
      if (scale && *scale != 1) return std::move(search).TakeScaled(*scale);
      doubts_depth = !scale;
    }
    const bool is_satisfied =
        search.IsSatisfied(method.sufficient_confidence) && !doubts_depth &&
        !search.DoubtsFocal();
    if (step.is_shortcut) {
      if (is_satisfied && search.LastIsBelieved()) {
        return std::move(search).Take();
      }
      if (!has_pose) search.DropLast();
      continue;
    }
    if (has_pose) needs_fallback = false;
    if (is_satisfied) break;
  }
  if (needs_fallback) search.VerifyAll();
  return std::move(search).Take();
}

namespace {

// Whether the answer with another focal length may stand in the place of that
// with the stated one.
bool MayReplace(const Verdict& other, const Verdict& stated, double odds) {
  return (other.is_believed() || !stated.is_believed()) &&
         OddsRatio(other, stated) >= odds;
}

}  // namespace

absl::StatusOr<Selection> SelectWithAnyCalibration(const Method& method,
                                                   Query& query,
                                                   Corrections& corrections) {
  TL_ASSIGN_OR_RETURN(
      Selection best,
      SelectWithAnyDepth(method, query, corrections.depth_scale));
  if (best.focal.features && best.focal.features->sigma > 0) {
    corrections.focal_error_sigmas = ErrorSigmas(*best.focal.features);
  }
  const FocalDoubt doubt(query.is_focal_doubtful(),
                         method.focal_sigma_scale.value_or(1));
  const int rounds = query.is_focal_open() ? kMaxFocalRounds.value : 0;
  for (int round = 0; round < rounds; ++round) {
    const std::optional<OtherFocal> other = doubt.Other(best.focal);
    if (!best.verdict || !other) break;
    Corrections tried = corrections;
    tried.focal_scale *= other->scale;
    TL_ASSIGN_OR_RETURN(camera::RgbdCalibration corrected,
                        WithFocal(query.calibration(), other->scale));
    query.set_calibration(std::move(corrected));
    TL_ASSIGN_OR_RETURN(Selection selection,
                        SelectWithAnyDepth(method, query, tried.depth_scale));
    if (!selection.verdict ||
        !MayReplace(*selection.verdict, *best.verdict, other->needed_odds)) {
      break;
    }
    best = std::move(selection);
    corrections = tried;
  }
  return best;
}

Pipeline::Pipeline(std::unique_ptr<const forest::ModelFile> model,
                   Method method)
    : model_(std::move(model)), method_(std::move(method)) {}

Query Pipeline::Ask(const image::Frame& frame,
                    const camera::RgbdCalibration& calibration,
                    const LocalizeOptions& options,
                    QueryScratch& scratch) const {
  Query query(frame, calibration, method_.depth_use, options, scratch);
  const camera::Camera& learnt = info().calibration.color;
  if (frame.is_camera_assumed || MayBeGuessed(calibration.color, learnt) ||
      (TellsLenses() && MayBeCutElsewhere(calibration.color, learnt))) {
    query.set_focal_doubtful();
  }
  query.set_focal_open(method_.focal_use == FocalUse::kCorrected);
  query.set_lens_open(query.is_focal_open() && query.is_focal_doubtful() &&
                      query.depth() == nullptr && TellsLenses());
  query.set_feature_reduction(FeatureReduction(calibration.color, learnt));
  query.set_depth_scale_open(method_.depth_use == DepthUse::kWhereGiven &&
                             query.depth() != nullptr);
  return query;
}

absl::StatusOr<bool> Pipeline::IsRather(Query query, Found& stated) const {
  // Once, without corrections: they take longer than all else, and a camera
  // that is right needs none to be better than one that is wrong.
  query.set_depth_scale_open(false);
  TL_ASSIGN_OR_RETURN(const Selection other, SelectCandidate(method_, query));
  Add(query.timings(), stated.timings);
  const auto& before = stated.selection.verdict;
  return other.verdict && other.verdict->is_believed() &&
         (!before || !before->is_believed() ||
          OddsRatio(*other.verdict, *before) >= kUnsureFocalOdds);
}

absl::Status Pipeline::TryOtherCameras(const image::Frame& frame,
                                       const camera::RgbdCalibration& stated,
                                       const LocalizeOptions& options,
                                       QueryScratch& scratch,
                                       Found& found) const {
  if (method_.focal_use != FocalUse::kCorrected) return absl::OkStatus();
  for (const camera::Camera& other :
       CentredCameras(stated.color, info().calibration.color)) {
    Query query = Ask(frame, WithColor(stated, other), options, scratch);
    TL_ASSIGN_OR_RETURN(const bool is_rather, IsRather(query, found));
    if (!is_rather) continue;
    found.corrections = {};
    TL_ASSIGN_OR_RETURN(
        found.selection,
        SelectWithAnyCalibration(method_, query, found.corrections));
    Add(query.timings(), found.timings);
    found.corrections.focal_scale *=
        camera::MeanFocal_px(other) / camera::MeanFocal_px(stated.color);
  }
  return absl::OkStatus();
}

absl::StatusOr<camera::Camera> Pipeline::AskAgainWithLens(
    const image::Frame& frame, const camera::RgbdCalibration& assumed,
    const LocalizeOptions& options, QueryScratch& scratch, Found& found) const {
  TL_ASSIGN_OR_RETURN(camera::RgbdCalibration last,
                      WithFocal(assumed, found.corrections.focal_scale));
  for (int round = 0; round < kMaxLensRounds; ++round) {
    const std::optional<AssumedLens> lens = found.selection.focal.lens;
    if (!lens || lens->is_as_assumed) break;
    const absl::StatusOr<camera::Camera> camera =
        WithLens(last.color, lens->found);
    if (!camera.ok()) break;
    last = WithColor(last, *camera);
    Query query = Ask(frame, last, options, scratch);
    query.set_focal_doubtful();
    query.set_lens_open(true);
    Corrections corrections;
    TL_ASSIGN_OR_RETURN(found.selection,
                        SelectWithAnyCalibration(method_, query, corrections));
    Add(query.timings(), found.timings);
    TL_ASSIGN_OR_RETURN(last, WithFocal(last, corrections.focal_scale));
    found.lens = lens->found;
  }
  if (found.lens) {
    found.corrections.focal_scale =
        camera::MeanFocal_px(last.color) / camera::MeanFocal_px(assumed.color);
  }
  return last.color;
}

bool Pipeline::TellsLenses() const {
  return method_.focal_sigma_scale &&
         *method_.focal_sigma_scale <= kMaxAssumedSigmaScale;
}

bool Pipeline::IsAssumedRightly(const Found& found,
                                const PoseEstimate& estimate) const {
  const FocalEvidence& focal = found.selection.focal;
  if (!focal.lens || !focal.lens->is_as_assumed ||
      !IsGuessConfirmed(focal,
                        kMaxAssumedFocalSigma / *method_.focal_sigma_scale)) {
    return false;
  }
  return !found.lens ||
         PositionSigma_m(estimate.covariance) <=
             kMaxLensSigma * method_.verifier->MaxPositionSigma();
}

std::optional<geometry::PoseCovariance> Pipeline::CameraDoubt(
    const Query& query, const Found& found) {
  if (!query.is_focal_doubtful() && found.corrections.focal_scale == 1) {
    return geometry::PoseCovariance{};
  }
  if (found.lens) return found.lens->added;
  const FocalEvidence& focal = found.selection.focal;
  if (focal.lens) return focal.lens->found.added;
  if (focal.features) return focal.features->added;
  return std::nullopt;
}

void Pipeline::Weigh(const Query& query, const Found& found,
                     PoseEstimate& estimate) const {
  const std::optional<Verdict>& verdict = found.selection.verdict;
  if (!verdict) return;
  if (query.depth() == nullptr) {
    WeighDoubt(verdict->of_features, CameraDoubt(query, found),
               method_.focal_sigma_scale.value_or(1),
               method_.verifier->MinConfidence(query.options()), estimate);
  }
  if ((query.is_camera_assumed() || found.lens) && verdict->is_believed() &&
      !IsAssumedRightly(found, estimate)) {
    estimate.outcome = Outcome::kNotLocalized;
    estimate.reason = NotLocalizedReason::kUnknownCamera;
    // The place is known.
    estimate.confidence = verdict->confidence;
  }
}

absl::Status Pipeline::AskAgainWithFocal(const image::Frame& frame,
                                         const camera::RgbdCalibration& assumed,
                                         const LocalizeOptions& options,
                                         QueryScratch& scratch,
                                         Found& found) const {
  const camera::Camera& learnt = info().calibration.color;
  TL_ASSIGN_OR_RETURN(const camera::RgbdCalibration corrected,
                      WithFocal(assumed, found.corrections.focal_scale));
  if (FeatureReduction(corrected.color, learnt) ==
      FeatureReduction(assumed.color, learnt)) {
    return absl::OkStatus();
  }
  Query query = Ask(frame, corrected, options, scratch);
  const double first_scale = found.corrections.focal_scale;
  found.corrections = {};
  TL_ASSIGN_OR_RETURN(found.selection, SelectWithAnyCalibration(
                                           method_, query, found.corrections));
  found.corrections.focal_scale *= first_scale;
  Add(query.timings(), found.timings);
  return absl::OkStatus();
}

absl::Status Pipeline::UndoShutter(const image::Frame& frame,
                                   const LocalizeOptions& options, Query& query,
                                   QueryScratch& scratch, Found& found) const {
  const std::optional<Verdict>& stated = found.selection.verdict;
  if (!info().shutter || !stated || method_.keyframes == nullptr ||
      method_.keyframes->features().empty() || query.is_focal_doubtful()) {
    return absl::OkStatus();
  }
  camera::RgbdCalibration calibration = query.calibration();
  const std::optional<pose::TurnEstimate> turn = MeasureTurn(
      query, *method_.keyframes, *info().shutter,
      camera::PoseOfSensor(stated->world_from_camera, calibration.pose_sensor,
                           camera::RgbdSensor::kColor, calibration));
  if (!turn) return absl::OkStatus();
  const camera::RgbdSensor pose_sensor = calibration.pose_sensor;
  calibration.pose_sensor = camera::RgbdSensor::kColor;
  const image::Frame undone =
      image::AtTimeStamp(frame, calibration, *info().shutter,
                         {.turn_rate_rad_s = turn->turn_rate_rad_s});
  calibration.pose_sensor = pose_sensor;
  Query asked = Ask(undone, calibration, options, scratch);
  asked.set_depth_scale_open(false);
  TL_ASSIGN_OR_RETURN(Selection selection, SelectCandidate(method_, asked));
  Add(asked.timings(), found.timings);
  // As one more way to explain what is seen, it has to explain it better.
  // Without depth a turn across the axis looks like a move, and a corrected
  // pose that is elsewhere may be the wrong one.
  if (!selection.verdict || !selection.verdict->is_believed() ||
      (stated->is_believed() &&
       (OddsRatio(*selection.verdict, *stated) < 1 ||
        (query.depth() == nullptr && AreApart(*selection.verdict, *stated))))) {
    return absl::OkStatus();
  }
  for (size_t i = 0; i < selection.verdict->covariance.size(); ++i) {
    selection.verdict->covariance[i] += turn->added_covariance[i];
  }
  found.selection = std::move(selection);
  return absl::OkStatus();
}

absl::StatusOr<PoseEstimate> Pipeline::Localize(
    const image::Frame& frame, const LocalizeOptions& options) const {
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  const camera::RgbdCalibration calibration =
      QueryCalibration(frame, info(), method_.depth_use);
  TL_RETURN_IF_ERROR(
      CheckFrame(frame, calibration, method_.depth_use, info().method));
  Pool<QueryScratch>::Lease scratch(scratch_);
  Query query = Ask(frame, calibration, options, *scratch);
  Found found;
  TL_ASSIGN_OR_RETURN(found.selection, SelectWithAnyCalibration(
                                           method_, query, found.corrections));
  if (frame.is_camera_assumed) {
    TL_RETURN_IF_ERROR(
        AskAgainWithFocal(frame, calibration, options, *scratch, found));
  }
  std::optional<camera::Camera> camera;
  if (query.is_lens_open()) {
    TL_ASSIGN_OR_RETURN(
        camera, AskAgainWithLens(frame, calibration, options, *scratch, found));
  }
  TL_RETURN_IF_ERROR(
      TryOtherCameras(frame, calibration, options, *scratch, found));
  TL_RETURN_IF_ERROR(UndoShutter(frame, options, query, *scratch, found));
  PoseEstimate estimate =
      Report(std::move(found.selection.candidate),
             found.selection.verdict ? &*found.selection.verdict : nullptr);
  Weigh(query, found, estimate);
  if (frame.is_camera_assumed || found.lens) estimate.found_camera = camera;
  estimate.focal_scale = found.corrections.focal_scale;
  estimate.focal_error_sigmas = found.corrections.focal_error_sigmas;
  estimate.depth_scale = found.corrections.depth_scale;
  estimate.timings = query.timings();
  Add(found.timings, estimate.timings);
  SetTotal(base::MillisecondsBetween(start, clock.Now()), estimate.timings);
  return estimate;
}

}  // namespace treeline::localizer
