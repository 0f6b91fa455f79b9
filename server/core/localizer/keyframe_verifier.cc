#include "server/core/localizer/keyframe_verifier.h"

#include <algorithm>
#include <optional>

#include "common/base/status_macros.h"
#include "server/core/keyframes/direct_alignment.h"
#include "server/core/localizer/alignment_trust.h"
#include "server/core/localizer/parameters.h"
#include "server/core/localizer/position_doubt.h"
#include "server/core/localizer/stated_camera.h"

namespace treeline::localizer {
namespace {

forest::PoseEvidence EvidenceOf(const keyframes::Alignment& aligned,
                                geometry::Vec3 from) {
  forest::PoseEvidence evidence;
  evidence.correlation = std::max(0.0, aligned.correlation);
  evidence.agreement = aligned.agreement;
  evidence.visible = aligned.visible;
  evidence.overlap = aligned.overlap;
  evidence.measured = aligned.measured;
  evidence.depth_agreement = aligned.depth_agreement;
  evidence.contradicted = aligned.contradicted;
  evidence.moved_m =
      geometry::Norm(aligned.world_from_camera.translation - from);
  return evidence;
}

// A narrow view sees little of each.
int AlignedKeyframes(const camera::Camera& stated,
                     const camera::Camera& learnt) {
  const int usual = keyframes::AlignmentOptions{}.keyframes;
  return std::clamp(
      static_cast<int>(std::min(1000.0, usual * Narrowness(stated, learnt))),
      usual, std::max<int>(usual, kMaxAlignedKeyframes));
}

// Whatever else speaks for the pose: it is a picture of the scene that was seen
// there, or the depth is not the frame's.
bool ContradictsDepth(const forest::PoseEvidence& evidence) {
  return evidence.measured >= kMinMeasuredPoints &&
         evidence.depth_agreement < kMinDepthAgreement;
}

}  // namespace

absl::StatusOr<std::unique_ptr<const KeyframeVerifier>>
KeyframeVerifier::Create(const forest::ModelFile& model, AlignmentUse use) {
  auto verifier = std::make_unique<KeyframeVerifier>();
  TL_ASSIGN_OR_RETURN(verifier->keyframes_,
                      keyframes::KeyframeMap::Read(model));
  verifier->use_ = use;
  verifier->learnt_ = model.info().calibration.color;
  verifier->confidence_ = model.info().confidence.value_or(
      verifier->keyframes_.empty() ? forest::ConfidenceModel::WithoutKeyframes()
                                   : forest::ConfidenceModel::Typical());
  return verifier;
}

pose::PoseWithCovariance KeyframeVerifier::Answer(
    const pose::RefinedPose& candidate,
    const pose::PoseWithCovariance& aligned) const {
  if (use_ == AlignmentUse::kReplaces) return aligned;
  return pose::FusePoses({candidate.world_from_camera, candidate.covariance},
                         aligned)
      .value_or(aligned);
}

Verdict KeyframeVerifier::Verify(Query& query,
                                 const Candidate& candidate) const {
  const Verdict verdict = Judge(query, candidate, /*evens_light=*/false);
  // With fewer features that agree, more that may be fitted lets more agree.
  if (!candidate.is_matched || candidate.pose->inliers < kSufficientMatches ||
      verdict.confidence >= kSufficientConfidence) {
    return verdict;
  }
  const Verdict evened = Judge(query, candidate, /*evens_light=*/true);
  if (evened.evidence.agreement <=
      kMinEvenedAgreement * verdict.evidence.agreement) {
    return verdict;
  }
  return evened.confidence > verdict.confidence ? evened : verdict;
}

Verdict KeyframeVerifier::Judge(Query& query, const Candidate& candidate,
                                bool evens_light) const {
  const pose::RefinedPose& pose = *candidate.pose;
  const camera::RgbdCalibration& calibration = query.calibration();
  Verdict verdict;
  verdict.world_from_camera = pose.world_from_camera;
  verdict.covariance = pose.covariance;
  if (use_ == AlignmentUse::kFuses && candidate.is_matched &&
      query.depth() == nullptr) {
    verdict.of_features = pose.covariance;
  }
  double sigma_m = PositionSigma_m(pose.covariance);
  const geometry::Rigid3 world_from_color =
      camera::PoseOfSensor(pose.world_from_camera, calibration.pose_sensor,
                           camera::RgbdSensor::kColor, calibration);
  const std::optional<keyframes::Alignment> aligned =
      keyframes::AlignToKeyframes(
          keyframes_, query.pyramid(), query.depth(), calibration,
          world_from_color,
          {.keyframes = AlignedKeyframes(calibration.color, learnt_),
           .evens_light = evens_light});
  if (aligned) {
    verdict.evidence = EvidenceOf(*aligned, world_from_color.translation);
    verdict.depth_scale = aligned->depth_scale;
    // Surfaces hold it, where depth is.
    const bool is_drawn_away = use_ == AlignmentUse::kFuses &&
                               query.depth() == nullptr &&
                               IsDrawnAway(candidate, verdict.evidence.moved_m);
    // The pose is left where it was.
    if (is_drawn_away) verdict.evidence.moved_m = 0;
    // With less overlap the candidate is surer of the pose.
    if (aligned->overlap >= kMinKeyframeOverlap && !is_drawn_away) {
      const pose::PoseWithCovariance answer = Answer(
          pose, {camera::PoseOfSensor(aligned->world_from_camera,
                                      camera::RgbdSensor::kColor,
                                      calibration.pose_sensor, calibration),
                 aligned->covariance});
      verdict.world_from_camera = answer.world_from_camera;
      sigma_m = std::min(sigma_m, PositionSigma_m(answer.covariance));
      verdict.covariance = answer.covariance;
      if (use_ == AlignmentUse::kFuses) {
        verdict.covariance = Widened(answer.covariance, kSharedErrors);
      }
    }
  }
  if (use_ == AlignmentUse::kFuses && !candidate.is_matched) {
    verdict.covariance = Widened(verdict.covariance, kForestErrors);
  }
  verdict.evidence.inlier_ratio = candidate.inlier_ratio();
  verdict.evidence.matches = candidate.is_matched ? pose.inliers : 0;
  verdict.evidence.distinct = candidate.distinct;
  verdict.evidence.sigma_m = sigma_m;
  verdict.confidence = confidence_.Probability(verdict.evidence);
  if (ContradictsDepth(verdict.evidence)) {
    forest::PoseEvidence of_picture = verdict.evidence;
    of_picture.measured = 0;
    verdict.picture_confidence = confidence_.Probability(of_picture);
  }
  verdict.reason = ReasonAgainst(
      {.has_enough_inliers =
           pose.inliers >=
           (candidate.is_matched ? kMinKeyframeInliers : kMinAnswerInliers),
       .is_determined = sigma_m <= MaxPositionSigma(),
       .fits_depth = !ContradictsDepth(verdict.evidence),
       .is_confident = verdict.confidence >= MinConfidence(query.options())});
  return verdict;
}

std::optional<keyframes::DepthScale> KeyframeVerifier::MeasureDepth(
    Query& query, const geometry::Rigid3& world_from_camera) const {
  if (query.depth() == nullptr) return std::nullopt;
  const camera::RgbdCalibration& calibration = query.calibration();
  const std::optional<keyframes::Alignment> aligned =
      keyframes::AlignToKeyframes(
          keyframes_, query.pyramid(), query.depth(), calibration,
          camera::PoseOfSensor(world_from_camera, calibration.pose_sensor,
                               camera::RgbdSensor::kColor, calibration),
          {.keyframes = AlignedKeyframes(calibration.color, learnt_),
           .only_measures_depth = true});
  return aligned ? aligned->depth_scale : std::nullopt;
}

}  // namespace treeline::localizer
