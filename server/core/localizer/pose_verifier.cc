#include "server/core/localizer/pose_verifier.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/base/status_macros.h"
#include "server/core/keyframes/direct_alignment.h"

namespace treeline {

double PositionSigma_m(const PoseCovariance& covariance) {
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

absl::StatusOr<PoseVerifier> PoseVerifier::Create(const ModelFile& model) {
  PoseVerifier verifier;
  TL_ASSIGN_OR_RETURN(verifier.keyframes_, KeyframeMap::Read(model));
  verifier.confidence_ = model.info().confidence.value_or(
      verifier.keyframes_.empty() ? ConfidenceModel::WithoutKeyframes()
                                  : ConfidenceModel::Typical());
  return verifier;
}

void PoseVerifier::Judge(const GrayPyramid& image, const DepthImage* depth,
                         const RgbdCalibration& calibration,
                         const LocalizeOptions& options,
                         PoseEstimate& estimate) const {
  PoseEvidence& evidence = estimate.evidence;
  evidence.inlier_ratio = estimate.inlier_ratio;
  const double sigma_m = PositionSigma_m(estimate.covariance);
  const Rigid3 world_from_color =
      PoseOfSensor(estimate.world_from_camera, calibration.pose_sensor,
                   RgbdSensor::kColor, calibration);
  const std::optional<Alignment> aligned = AlignToKeyframes(
      keyframes_, image, depth, calibration, world_from_color, {});
  if (aligned) {
    evidence.correlation = std::max(0.0, aligned->correlation);
    evidence.agreement = aligned->agreement;
    evidence.visible = aligned->visible;
    evidence.overlap = aligned->overlap;
    evidence.measured = aligned->measured;
    evidence.depth_agreement = aligned->depth_agreement;
    evidence.moved_m = Norm(aligned->world_from_camera.translation -
                            world_from_color.translation);
    if (aligned->overlap >= kMinOverlap) {
      estimate.world_from_camera =
          PoseOfSensor(aligned->world_from_camera, RgbdSensor::kColor,
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

}  // namespace treeline
