#include "server/core/localizer/oriented_localizer.h"

#include <utility>

#include "common/base/status_macros.h"
#include "common/image/quarter_turn.h"
#include "server/core/localizer/parameters.h"

namespace treeline::localizer {
namespace {

using geometry::Rigid3;
using image::QuarterTurn;

// Of the pose sensor. Without depth, a localizer places the depth camera beside
// the turned colour camera as it stands beside the one that is not.
Rigid3 TurnedFromSensor(const image::Frame& frame, QuarterTurn turn,
                        const camera::RgbdCalibration& scene) {
  const Rigid3 turned_from_camera{image::TurnedFromCamera(turn), {}};
  if (frame.depth || scene.pose_sensor == camera::RgbdSensor::kColor) {
    return turned_from_camera;
  }
  return scene.color_from_depth.Inverse() * turned_from_camera *
         scene.color_from_depth;
}

Rigid3 Composed(const Rigid3& world_from_turned,
                const Rigid3& turned_from_sensor) {
  Rigid3 world_from_sensor = world_from_turned * turned_from_sensor;
  world_from_sensor.rotation = geometry::Normalized(world_from_sensor.rotation);
  return world_from_sensor;
}

// The pose is another frame's; its covariance is of the world's axes, and stays
// but for the arm of a depth camera, which is short.
void TurnBack(const image::Frame& frame, QuarterTurn turn,
              const Rigid3& turned_from_sensor, PoseEstimate& estimate) {
  estimate.world_from_camera =
      Composed(estimate.world_from_camera, turned_from_sensor);
  const bool swaps = turn != QuarterTurn::kHalf;
  const int width = swaps ? frame.color.height : frame.color.width;
  const int height = swaps ? frame.color.width : frame.color.height;
  const QuarterTurn back = image::Inverse(turn);
  if (estimate.found_camera) {
    estimate.found_camera = image::Turned(*estimate.found_camera, back);
  }
  const geometry::Rotation3 camera_from_turned = image::TurnedFromCamera(back);
  for (Correspondence& sample : estimate.correspondences) {
    sample.color_pixel = Turned(sample.color_pixel, width, height, back);
    sample.point_in_camera = camera_from_turned * sample.point_in_camera;
  }
}

double Threshold(const forest::ModelInfo& info) {
  return info.confidence.value_or(forest::ConfidenceModel::Typical()).threshold;
}

// Whether no other turn needs to be tried.
bool IsSettled(const PoseEstimate& estimate, double threshold) {
  return estimate.confidence >= threshold &&
         (estimate.outcome == Outcome::kLocalized ||
          estimate.reason == NotLocalizedReason::kUnknownCamera);
}

// Takes the odds that a pose is at another turn than the frame's into account.
void Discount(double min_confidence, PoseEstimate& estimate) {
  const double p = estimate.confidence;
  estimate.confidence = p / (p + kOtherTurnOdds * (1 - p));
  if (estimate.outcome == Outcome::kLocalized &&
      estimate.confidence < min_confidence) {
    estimate.outcome = Outcome::kNotLocalized;
    estimate.reason = NotLocalizedReason::kLowConfidence;
  }
}

}  // namespace

OrientedLocalizer::OrientedLocalizer(std::unique_ptr<const Localizer> upright,
                                     bool other_turns)
    : upright_(std::move(upright)), other_turns_(other_turns) {}

absl::StatusOr<PoseEstimate> OrientedLocalizer::Localize(
    const image::Frame& frame, const LocalizeOptions& options) const {
  const QuarterTurn first = frame.orientation.upright_turn;
  TL_ASSIGN_OR_RETURN(PoseEstimate best, LocalizeTurned(frame, first, options));
  const double threshold = Threshold(info());
  if (frame.orientation.is_certain || !other_turns_ ||
      IsSettled(best, threshold)) {
    return best;
  }
  LocalizeTimings timings = best.timings;
  for (const QuarterTurn turn : image::kQuarterTurns) {
    if (turn == first) continue;
    TL_ASSIGN_OR_RETURN(PoseEstimate estimate,
                        LocalizeTurned(frame, turn, options));
    Add(estimate.timings, timings);
    Discount(options.min_confidence.value_or(threshold), estimate);
    if (IsBetter(estimate, best)) best = std::move(estimate);
  }
  best.timings = timings;
  return best;
}

absl::StatusOr<PoseEstimate> OrientedLocalizer::LocalizeTurned(
    const image::Frame& frame, QuarterTurn turn,
    const LocalizeOptions& options) const {
  if (turn == QuarterTurn::kNone) return upright_->Localize(frame, options);
  image::Frame turned = Turned(frame, turn);
  const camera::RgbdCalibration& scene = info().calibration;
  if (!turned.calibration) turned.calibration = Turned(scene, turn);
  const Rigid3 turned_from_sensor = TurnedFromSensor(frame, turn, scene);
  LocalizeOptions turned_options = options;
  if (turned_options.priors.pose) {
    Rigid3& prior = turned_options.priors.pose->world_from_camera;
    prior = Composed(prior, turned_from_sensor.Inverse());
  }
  TL_ASSIGN_OR_RETURN(PoseEstimate estimate,
                      upright_->Localize(turned, turned_options));
  TurnBack(frame, turn, turned_from_sensor, estimate);
  return estimate;
}

}  // namespace treeline::localizer
