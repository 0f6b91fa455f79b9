#include "server/service/localize_rpc.h"

#include <cmath>
#include <optional>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/wire/frame.h"
#include "common/wire/geometry.h"
#include "server/core/localizer/pose_prior.h"
#include "server/service/convert.h"

namespace treeline {
namespace {

constexpr double kLongestBudget_ms = 24 * 3600 * 1000.0;

// Whether a call is still worth an answer at `now`.
absl::Status CheckWanted(const CallInfo& call, MonotonicTime now,
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

absl::StatusOr<std::optional<PosePrior>> PriorFrom(
    const v1::LocalizeOptions& options) {
  if (!options.has_prior()) return std::nullopt;
  constexpr char kField[] = "options.prior";
  PosePrior prior;
  TL_ASSIGN_OR_RETURN(prior.world_from_camera,
                      FromProto(options.prior().world_from_camera(),
                                absl::StrCat(kField, ".world_from_camera")));
  prior.position_radius_m = options.prior().position_radius_m();
  prior.rotation_radius_rad = options.prior().rotation_radius_rad();
  if (const absl::Status valid = prior.Validate(); !valid.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(kField, ".", valid.message()));
  }
  return prior;
}

}  // namespace

absl::Status CheckOptions(const v1::LocalizeOptions& options) {
  if (options.has_time_budget_ms() &&
      !(options.time_budget_ms() > 0 &&
        options.time_budget_ms() <= kLongestBudget_ms)) {
    return FieldError("options.time_budget_ms",
                      absl::StrCat(options.time_budget_ms(),
                                   " is not a positive time up to a day"));
  }
  return PriorFrom(options).status();
}

absl::StatusOr<v1::LocalizeResponse> LocalizeRpc::Handle(
    const v1::LocalizeRequest& request, const Scene& scene,
    const CallInfo& call, CallRecord& record) const {
  const MonotonicTime start = clock_.Now();
  record.timings.queue_ms = MillisecondsBetween(call.arrival, start);
  record.model_version = scene.version;
  record.method = scene.localizer->info().method;
  const absl::Status wanted = CheckWanted(call, start, "in the queue");
  record.shed = absl::IsDeadlineExceeded(wanted);
  TL_RETURN_IF_ERROR(wanted);

  TL_ASSIGN_OR_RETURN(const std::optional<PosePrior> prior,
                      PriorFrom(request.options()));
  const RgbdCalibration calibration = QueryCalibration(scene);
  TL_ASSIGN_OR_RETURN(
      Frame frame, FromProto(request.frame(), calibration, limits_, "frame"));
  // The localizer itself only knows the model's.
  if (!frame.calibration && HasOwnCamera(scene)) {
    frame.calibration = calibration;
  }
  const MonotonicTime decoded = clock_.Now();
  record.timings.decode_ms = MillisecondsBetween(start, decoded);
  TL_RETURN_IF_ERROR(CheckWanted(call, decoded, "while decoding"));

  LocalizeOptions options;
  options.seed = request.options().seed();
  options.keep_correspondences = request.options().include_correspondences();
  options.stop = call.stop;
  absl::StatusOr<PoseEstimate> estimate =
      scene.localizer->Localize(frame, options);
  const MonotonicTime end = clock_.Now();
  if (!estimate.ok()) {
    // The deadline stops the work in the same way as the client does.
    if (absl::IsCancelled(estimate.status())) {
      TL_RETURN_IF_ERROR(CheckWanted(call, end, "while localizing"));
    }
    return estimate.status();
  }
  if (prior) ApplyPrior(*prior, *estimate);
  record.outcome = estimate->outcome;
  record.reason = estimate->reason;
  record.inliers = estimate->inliers;
  record.samples = estimate->samples;
  record.confidence = estimate->confidence;
  record.timings.localize = estimate->timings;

  v1::LocalizeResponse response = ToProto(*estimate, calibration.pose_sensor);
  response.set_scene(scene.name);
  response.set_model_version(scene.version);
  record.timings.total_ms = MillisecondsBetween(call.arrival, clock_.Now());
  *response.mutable_timings() = ToProto(record.timings);
  return response;
}

}  // namespace treeline
