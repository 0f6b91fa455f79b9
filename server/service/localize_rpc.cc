#include "server/service/localize_rpc.h"

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/camera/derived_camera.h"
#include "common/image/quarter_turn.h"
#include "common/wire/camera.h"
#include "common/wire/frame.h"
#include "common/wire/geometry.h"
#include "common/wire/pose_prior.h"
#include "server/core/forest/confidence_model.h"
#include "server/core/recognition/localize_among.h"
#include "server/service/convert.h"

namespace treeline::service {
namespace {

constexpr double kLongestBudget_ms = 24 * 3600 * 1000.0;
// Of a ranking of hundreds, as many are told.
constexpr int kMaxCandidates = 16;

// Whether a call is still worth an answer at `now`.
absl::Status CheckWanted(const CallInfo& call, base::MonotonicTime now,
                         absl::string_view where) {
  if (now >= call.deadline) {
    return absl::DeadlineExceededError(
        absl::StrCat("the deadline passed ", where));
  }
  if (call.stop.stop_requested()) {
    return absl::CancelledError(absl::StrCat("the call was cancelled ", where));
  }
  return absl::OkStatus();
}

// The same for one that leaves the queue.
absl::Status CheckWantedInQueue(const CallInfo& call, base::MonotonicTime now,
                                CallRecord& record) {
  absl::Status wanted = CheckWanted(call, now, "in the queue");
  record.shed = absl::IsDeadlineExceeded(wanted);
  return wanted;
}

absl::StatusOr<geometry::PosePriors> PriorsFrom(
    const v1::LocalizeOptions& options) {
  return wire::PriorsFromProto(options, "options");
}

absl::StatusOr<localizer::LocalizeOptions> OptionsOf(
    const v1::LocalizeRequest& request, const CallInfo& call) {
  localizer::LocalizeOptions options;
  options.seed = request.options().seed();
  options.keep_correspondences = request.options().include_correspondences();
  if (request.options().has_min_confidence()) {
    options.min_confidence = request.options().min_confidence();
  }
  TL_ASSIGN_OR_RETURN(options.priors, PriorsFrom(request.options()));
  options.stop = call.stop;
  return options;
}

}  // namespace

absl::Status CheckOptions(const v1::LocalizeOptions& options) {
  if (options.has_time_budget_ms() &&
      !(options.time_budget_ms() > 0 &&
        options.time_budget_ms() <= kLongestBudget_ms)) {
    return wire::FieldError(
        "options.time_budget_ms",
        absl::StrCat(options.time_budget_ms(),
                     " is not a positive time up to a day"));
  }
  if (options.has_min_confidence() &&
      !(options.min_confidence() >= 0 && options.min_confidence() <= 1)) {
    return wire::FieldError(
        "options.min_confidence",
        absl::StrCat(options.min_confidence(), " is not a probability"));
  }
  return PriorsFrom(options).status();
}

absl::StatusOr<v1::LocalizeResponse> LocalizeRpc::Handle(
    const v1::LocalizeRequest& request, const repository::Scene& scene,
    const CallInfo& call, CallRecord& record) const {
  const base::MonotonicTime start = clock_.Now();
  record.timings.queue_ms = base::MillisecondsBetween(call.arrival, start);
  record.model_version = scene.version;
  record.method = scene.localizer->info().method;
  TL_RETURN_IF_ERROR(CheckWantedInQueue(call, start, record));

  TL_ASSIGN_OR_RETURN(const localizer::LocalizeOptions options,
                      OptionsOf(request, call));
  const camera::RgbdCalibration calibration =
      repository::QueryCalibration(scene);
  TL_ASSIGN_OR_RETURN(
      image::Frame frame,
      wire::FromProto(request.frame(), calibration, limits_, "frame"));
  // The localizer itself only knows the model's.
  if (!frame.calibration && repository::HasOwnCamera(scene)) {
    frame.calibration = calibration;
  }
  const base::MonotonicTime decoded = clock_.Now();
  record.timings.decode_ms = base::MillisecondsBetween(start, decoded);
  TL_RETURN_IF_ERROR(CheckWanted(call, decoded, "while decoding"));

  return Answer(scene.localizer->Localize(frame, options), options.priors,
                scene, call, record);
}

absl::StatusOr<v1::LocalizeResponse> LocalizeRpc::HandleAmong(
    const v1::LocalizeRequest& request, const SceneRecognizer& recognizer,
    const AcquireByName& acquire, const CallInfo& call,
    CallRecord& record) const {
  const base::MonotonicTime start = clock_.Now();
  record.timings.queue_ms = base::MillisecondsBetween(call.arrival, start);
  TL_RETURN_IF_ERROR(CheckWantedInQueue(call, start, record));
  TL_ASSIGN_OR_RETURN(const localizer::LocalizeOptions options,
                      OptionsOf(request, call));
  TL_ASSIGN_OR_RETURN(image::Frame frame,
                      wire::PixelsFromProto(request.frame(), limits_, "frame"));
  const std::vector<std::string> candidates(request.candidate_scenes().begin(),
                                            request.candidate_scenes().end());
  // Training frames, which scenes are known by, are upright; colour counts.
  const image::QuarterTurn turn = frame.orientation.upright_turn;
  image::Frame upright;
  if (turn != image::QuarterTurn::kNone) {
    upright.color = Turned(frame.color, turn);
  }
  const std::vector<recognition::SceneScore> ranking = recognizer.Rank(
      turn == image::QuarterTurn::kNone ? frame : upright, candidates);
  const base::MonotonicTime decoded = clock_.Now();
  record.timings.decode_ms = base::MillisecondsBetween(start, decoded);
  TL_RETURN_IF_ERROR(CheckWanted(call, decoded, "while decoding"));
  if (ranking.empty()) {
    return base::WithReason(
        absl::FailedPreconditionError(
            "no scene can be recognized: their models hold no descriptors, or "
            "are not here yet; name the scene"),
        "NO_SCENE_TO_RECOGNIZE");
  }

  std::map<std::string, std::shared_ptr<const repository::Scene>> used;
  const auto try_scene =
      [&](const std::string& name) -> absl::StatusOr<recognition::SceneToTry> {
    TL_ASSIGN_OR_RETURN(std::shared_ptr<const repository::Scene> scene,
                        acquire(name));
    const camera::RgbdCalibration calibration =
        repository::QueryCalibration(*scene);
    recognition::SceneToTry to_try;
    to_try.localizer = scene->localizer;
    TL_ASSIGN_OR_RETURN(to_try.calibration,
                        wire::CalibrationFromProto(request.frame(), frame,
                                                   calibration, "frame"));
    to_try.is_camera_assumed =
        wire::AssumedCamera(request.frame(), frame, calibration).has_value();
    if (!to_try.calibration && repository::HasOwnCamera(*scene)) {
      to_try.calibration = calibration;
    }
    used[name] = std::move(scene);
    return to_try;
  };
  absl::StatusOr<recognition::AmongResult> result =
      recognition::LocalizeAmong(frame, ranking, try_scene, options);
  if (!result.ok()) {
    return Answer(result.status(), options.priors, repository::Scene{}, call,
                  record);
  }
  const repository::Scene& scene = *used.at(result->scene);
  record.scene = scene.name;
  record.model_version = scene.version;
  record.method = scene.localizer->info().method;
  TL_ASSIGN_OR_RETURN(
      v1::LocalizeResponse response,
      Answer(std::move(result->estimate), options.priors, scene, call, record));
  for (const recognition::ConsideredScene& considered : result->considered) {
    *response.add_candidates() = ToProto(considered);
    if (response.candidates_size() == kMaxCandidates) break;
  }
  return response;
}

absl::StatusOr<v1::LocalizeResponse> LocalizeRpc::Answer(
    absl::StatusOr<localizer::PoseEstimate> estimate,
    const geometry::PosePriors& priors, const repository::Scene& scene,
    const CallInfo& call, CallRecord& record) const {
  const base::MonotonicTime end = clock_.Now();
  if (!estimate.ok()) {
    // The deadline stops the work in the same way as the client does.
    if (absl::IsCancelled(estimate.status())) {
      TL_RETURN_IF_ERROR(CheckWanted(call, end, "while localizing"));
    }
    return estimate.status();
  }
  localizer::ApplyPriors(priors, *estimate);
  record.outcome = estimate->outcome;
  record.reason = estimate->reason;
  if (estimate->outcome == localizer::Outcome::kLocalized) {
    record.world_from_camera = estimate->world_from_camera;
  }
  record.inliers = estimate->inliers;
  record.samples = estimate->samples;
  record.confidence = estimate->confidence;
  record.timings.localize = estimate->timings;

  v1::LocalizeResponse response =
      ToProto(*estimate, scene.localizer->info().calibration.pose_sensor);
  response.set_scene(scene.name);
  response.set_model_version(scene.version);
  response.set_confidence_threshold(
      scene.localizer->info()
          .confidence.value_or(forest::ConfidenceModel::Typical())
          .threshold);
  record.timings.total_ms =
      base::MillisecondsBetween(call.arrival, clock_.Now());
  *response.mutable_timings() = ToProto(record.timings);
  return response;
}

}  // namespace treeline::service
