#include "server/core/localizer/pose_verifier.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/base/status_macros.h"
#include "server/core/keyframes/direct_alignment.h"

namespace treeline::localizer {

double PositionSigma_m(const geometry::PoseCovariance& covariance) {
  return std::sqrt(std::max({covariance[0], covariance[7], covariance[14]}));
}

namespace {

// Fewer inliers are no answer, whatever else speaks for it.
constexpr int kMinInliers = 15;
// With less overlap with keyframes the forest knows the pose better.
constexpr double kMinOverlap = 0.1;
// The inliers must determine the position this well (m).
constexpr double kMaxPositionSigma_m = 0.05;

}  // namespace

absl::StatusOr<PoseVerifier> PoseVerifier::Create(
    const forest::ModelFile& model) {
  PoseVerifier verifier;
  TL_ASSIGN_OR_RETURN(verifier.keyframes_, keyframes::KeyframeMap::Read(model));
  verifier.confidence_ = model.info().confidence.value_or(
      verifier.keyframes_.empty() ? forest::ConfidenceModel::WithoutKeyframes()
                                  : forest::ConfidenceModel::Typical());
  return verifier;
}

void PoseVerifier::Judge(const features::GrayPyramid& image,
                         const image::DepthImage* depth,
                         const camera::RgbdCalibration& calibration,
                         const LocalizeOptions& options,
                         PoseEstimate& estimate) const {
  forest::PoseEvidence& evidence = estimate.evidence;
  evidence.inlier_ratio = estimate.inlier_ratio;
  const double sigma_m = PositionSigma_m(estimate.covariance);
  const geometry::Rigid3 world_from_color =
      camera::PoseOfSensor(estimate.world_from_camera, calibration.pose_sensor,
                           camera::RgbdSensor::kColor, calibration);
  const std::optional<keyframes::Alignment> aligned =
      keyframes::AlignToKeyframes(keyframes_, image, depth, calibration,
                                  world_from_color, {});
  if (aligned) {
    evidence.correlation = std::max(0.0, aligned->correlation);
    evidence.agreement = aligned->agreement;
    evidence.visible = aligned->visible;
    evidence.overlap = aligned->overlap;
    evidence.measured = aligned->measured;
    evidence.depth_agreement = aligned->depth_agreement;
    evidence.moved_m = geometry::Norm(aligned->world_from_camera.translation -
                                      world_from_color.translation);
    if (aligned->overlap >= kMinOverlap) {
      estimate.world_from_camera = camera::PoseOfSensor(
          aligned->world_from_camera, camera::RgbdSensor::kColor,
          calibration.pose_sensor, calibration);
      estimate.covariance = aligned->covariance;
    }
  }
  estimate.confidence = confidence_.Probability(evidence);
  const bool is_determined =
      std::min(sigma_m, PositionSigma_m(estimate.covariance)) <=
      kMaxPositionSigma_m;
  if (estimate.inliers < kMinInliers) {
    estimate.reason = NotLocalizedReason::kTooFewInliers;
  } else if (!is_determined) {
    estimate.reason = NotLocalizedReason::kPoorlyConstrained;
  } else if (estimate.confidence <
             options.min_confidence.value_or(confidence_.threshold)) {
    estimate.reason = NotLocalizedReason::kLowConfidence;
  } else {
    estimate.reason = NotLocalizedReason::kNone;
    estimate.outcome = Outcome::kLocalized;
  }
}

}  // namespace treeline::localizer
