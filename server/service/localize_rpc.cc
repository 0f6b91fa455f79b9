#include "server/service/localize_rpc.h"

#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/wire/frame.h"
#include "server/service/convert.h"

namespace treeline {
namespace {

// Whether a call is still worth an answer at `now`.
absl::Status CheckWanted(const CallContext& context, MonotonicTime now,
                         absl::string_view where) {
  if (now >= context.deadline) {
    return absl::DeadlineExceededError(
        absl::StrCat("the deadline passed ", where));
  }
  if (context.stop.stop_requested()) {
    return absl::CancelledError(absl::StrCat("the call was cancelled ", where));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<v1::LocalizeResponse> LocalizeRpc::Handle(
    const v1::LocalizeRequest& request, const CallContext& context,
    CallRecord& record) const {
  record.scene = request.scene().substr(0, kLongestName);
  const MonotonicTime start = clock_.Now();
  record.timings.queue_ms = MillisecondsBetween(context.arrival, start);
  TL_RETURN_IF_ERROR(CheckWanted(context, start, "in the queue"));

  TL_ASSIGN_OR_RETURN(
      const std::shared_ptr<const Scene> scene,
      repository_.Acquire(request.scene(), request.model_version(),
                          context.stop));
  record.model_version = scene->version;
  const RgbdCalibration calibration = QueryCalibration(*scene);
  TL_ASSIGN_OR_RETURN(
      Frame frame, FromProto(request.frame(), calibration, limits_, "frame"));
  // The localizer itself only knows the model's.
  if (!frame.calibration && HasOwnCamera(*scene)) {
    frame.calibration = calibration;
  }
  const MonotonicTime decoded = clock_.Now();
  record.timings.decode_ms = MillisecondsBetween(start, decoded);
  TL_RETURN_IF_ERROR(CheckWanted(context, decoded, "while decoding"));

  LocalizeOptions options;
  options.seed = request.options().seed();
  options.keep_correspondences = request.options().include_correspondences();
  options.stop = context.stop;
  const absl::StatusOr<PoseEstimate> estimate =
      scene->localizer->Localize(frame, options);
  const MonotonicTime end = clock_.Now();
  if (!estimate.ok()) {
    // The deadline stops the work in the same way as the client does.
    if (absl::IsCancelled(estimate.status())) {
      TL_RETURN_IF_ERROR(CheckWanted(context, end, "while localizing"));
    }
    return estimate.status();
  }
  record.outcome = estimate->outcome;
  record.reason = estimate->reason;
  record.inliers = estimate->inliers;
  record.samples = estimate->samples;
  record.timings.localize = estimate->timings;

  v1::LocalizeResponse response = ToProto(*estimate, calibration.pose_sensor);
  response.set_scene(scene->name);
  response.set_model_version(scene->version);
  record.timings.total_ms = MillisecondsBetween(context.arrival, clock_.Now());
  *response.mutable_timings() = ToProto(record.timings);
  return response;
}

}  // namespace treeline
