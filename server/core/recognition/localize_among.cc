#include "server/core/recognition/localize_among.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::recognition {
namespace {

absl::Status Validate(const AmongOptions& options) {
  if (options.max_tried < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "max_tried is ", options.max_tried, "; it must be positive"));
  }
  // Written so that NaN fails.
  if (!(options.sure_confidence >= 0 && options.sure_confidence <= 1)) {
    return absl::InvalidArgumentError(absl::StrCat("sure_confidence is ",
                                                   options.sure_confidence,
                                                   "; it must lie in [0, 1]"));
  }
  return absl::OkStatus();
}

bool EndsEverything(const absl::Status& status) {
  return absl::IsCancelled(status) || absl::IsDeadlineExceeded(status);
}

bool IsLocalized(const localizer::PoseEstimate& estimate) {
  return estimate.outcome == localizer::Outcome::kLocalized;
}

}  // namespace

absl::StatusOr<AmongResult> LocalizeAmong(
    image::Frame frame, std::span<const SceneScore> ranking,
    const AcquireScene& acquire, const localizer::LocalizeOptions& localize,
    const AmongOptions& options) {
  TL_RETURN_IF_ERROR(Validate(options));
  AmongResult result;
  for (const SceneScore& score : ranking) {
    result.considered.push_back(
        {.scene = score.scene, .similarity = score.similarity, .status = {}});
  }
  int tried = 0;
  localizer::LocalizeTimings timings;
  absl::Status first_problem;
  for (ConsideredScene& considered : result.considered) {
    if (tried == options.max_tried) break;
    if (localize.stop.stop_requested()) {
      return absl::CancelledError("stopped while trying scenes");
    }
    const auto give_up = [&](const absl::Status& status) {
      considered.status = status;
      first_problem.Update(status);
    };
    absl::StatusOr<SceneToTry> scene = acquire(considered.scene);
    if (!scene.ok()) {
      if (EndsEverything(scene.status())) return scene.status();
      give_up(scene.status());
      continue;
    }
    frame.calibration = std::move(scene->calibration);
    frame.is_camera_assumed = scene->is_camera_assumed;
    absl::StatusOr<localizer::PoseEstimate> estimate =
        scene->localizer->Localize(frame, localize);
    if (!estimate.ok()) {
      if (EndsEverything(estimate.status())) return estimate.status();
      give_up(estimate.status());
      continue;
    }
    ++tried;
    considered.tried = true;
    considered.outcome = estimate->outcome;
    considered.confidence = estimate->confidence;
    considered.inliers = estimate->inliers;
    localizer::Add(estimate->timings, timings);
    if (tried == 1 || IsBetter(*estimate, result.estimate)) {
      result.scene = considered.scene;
      result.localizer = std::move(scene->localizer);
      result.estimate = *std::move(estimate);
    }
    if (IsLocalized(result.estimate) &&
        result.estimate.confidence >= options.sure_confidence) {
      break;
    }
  }
  if (tried == 0 && !first_problem.ok()) return first_problem;
  result.estimate.timings = timings;
  return result;
}

}  // namespace treeline::recognition
