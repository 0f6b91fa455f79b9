#include "server/core/localizer/keyframe_verifier.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/status_macros.h"
#include "common/camera/derived_camera.h"
#include "server/core/localizer/parameters.h"

namespace treeline::localizer {
namespace {

// Whether the camera's focal length is not what the image shows.
bool HasOtherFocalLength(const keyframes::Alignment& aligned) {
  const double size = std::abs(aligned.focal_log_scale);
  return size > kFocalTolerance &&
         size > kFocalSigmas * aligned.focal_log_sigma;
}

forest::PoseEvidence EvidenceOf(const keyframes::Alignment& aligned,
                                geometry::Vec3 from) {
  forest::PoseEvidence evidence;
  evidence.correlation = std::max(0.0, aligned.correlation);
  evidence.agreement = aligned.agreement;
  evidence.visible = aligned.visible;
  evidence.overlap = aligned.overlap;
  evidence.measured = aligned.measured;
  evidence.depth_agreement = aligned.depth_agreement;
  evidence.moved_m =
      geometry::Norm(aligned.world_from_camera.translation - from);
  return evidence;
}

}  // namespace

absl::StatusOr<std::unique_ptr<const KeyframeVerifier>>
KeyframeVerifier::Create(const forest::ModelFile& model, AlignmentUse use) {
  auto verifier = std::make_unique<KeyframeVerifier>();
  TL_ASSIGN_OR_RETURN(verifier->keyframes_,
                      keyframes::KeyframeMap::Read(model));
  verifier->use_ = use;
  verifier->confidence_ = model.info().confidence.value_or(
      verifier->keyframes_.empty() ? forest::ConfidenceModel::WithoutKeyframes()
                                   : forest::ConfidenceModel::Typical());
  return verifier;
}

pose::PoseWithCovariance KeyframeVerifier::Answer(
    const pose::RefinedPose& candidate, const FocalAlignment& aligned,
    const geometry::Rigid3& world_from_camera) const {
  const pose::PoseWithCovariance answer{world_from_camera,
                                        aligned.alignment.covariance};
  // What was found with another focal length is no estimate.
  if (use_ == AlignmentUse::kReplaces || aligned.focal_scale != 1) {
    return answer;
  }
  return pose::FusePoses({candidate.world_from_camera, candidate.covariance},
                         answer)
      .value_or(answer);
}

std::optional<KeyframeVerifier::FocalAlignment> KeyframeVerifier::Align(
    Query& query, const geometry::Rigid3& world_from_color) const {
  const auto align = [&](const camera::RgbdCalibration& calibration,
                         const geometry::Rigid3& start) {
    return keyframes::AlignToKeyframes(keyframes_, query.pyramid(),
                                       query.depth(), calibration, start, {});
  };
  const std::optional<keyframes::Alignment> stated =
      align(query.calibration(), world_from_color);
  if (!stated) return std::nullopt;
  FocalAlignment best{*stated};
  if (use_ == AlignmentUse::kReplaces) return best;
  camera::RgbdCalibration calibration = query.calibration();
  for (int i = 0; i < kMaxFocalSteps && HasOtherFocalLength(best.alignment);
       ++i) {
    const double scale =
        best.focal_scale * std::exp(best.alignment.focal_log_scale);
    absl::StatusOr<camera::Camera> camera =
        camera::FocalScaled(query.camera(), scale);
    if (!camera.ok()) break;
    calibration.color = *std::move(camera);
    const std::optional<keyframes::Alignment> aligned =
        align(calibration, best.alignment.world_from_camera);
    if (!aligned || aligned->correlation < best.alignment.correlation) break;
    best = {*aligned, scale};
  }
  return best;
}

Verdict KeyframeVerifier::Verify(Query& query,
                                 const Candidate& candidate) const {
  const pose::RefinedPose& pose = *candidate.pose;
  const camera::RgbdCalibration& calibration = query.calibration();
  Verdict verdict;
  verdict.world_from_camera = pose.world_from_camera;
  verdict.covariance = pose.covariance;
  const geometry::Rigid3 world_from_color =
      camera::PoseOfSensor(pose.world_from_camera, calibration.pose_sensor,
                           camera::RgbdSensor::kColor, calibration);
  bool is_focal_known = true;
  if (const auto aligned = Align(query, world_from_color)) {
    verdict.evidence =
        EvidenceOf(aligned->alignment, world_from_color.translation);
    is_focal_known = !HasOtherFocalLength(aligned->alignment);
    verdict.focal_scale = aligned->focal_scale;
    // With less overlap the candidate is surer of the pose.
    if (aligned->alignment.overlap >= kMinKeyframeOverlap) {
      const pose::PoseWithCovariance answer =
          Answer(pose, *aligned,
                 camera::PoseOfSensor(aligned->alignment.world_from_camera,
                                      camera::RgbdSensor::kColor,
                                      calibration.pose_sensor, calibration));
      verdict.world_from_camera = answer.world_from_camera;
      verdict.covariance = answer.covariance;
    }
  }
  const double sigma_m = std::min(PositionSigma_m(pose.covariance),
                                  PositionSigma_m(verdict.covariance));
  verdict.evidence.inlier_ratio = candidate.inlier_ratio();
  verdict.evidence.matches = candidate.is_matched ? pose.inliers : 0;
  verdict.evidence.sigma_m = sigma_m;
  verdict.confidence = confidence_.Probability(verdict.evidence);
  verdict.reason = ReasonAgainst(
      {.has_enough_inliers = pose.inliers >= kMinAnswerInliers,
       .is_determined = sigma_m <= kMaxPositionSigma_m &&
                        (use_ == AlignmentUse::kReplaces || is_focal_known),
       .is_confident =
           verdict.confidence >=
           query.options().min_confidence.value_or(confidence_.threshold)});
  return verdict;
}

}  // namespace treeline::localizer
