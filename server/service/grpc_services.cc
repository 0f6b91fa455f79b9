#include "server/service/grpc_services.h"

#include <algorithm>
#include <exception>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/wire/status.h"
#include "server/service/get_scene_rpc.h"
#include "server/service/list_scenes_rpc.h"

namespace treeline {
namespace {

// Bounds of what a client that is turned away is told to wait.
constexpr double kMinPushback_ms = 10;
constexpr double kMaxPushback_ms = 2000;

// gRPC gives deadlines on the system clock; everything here is on the
// monotonic one.
MonotonicTime MonotonicDeadline(const grpc::CallbackServerContext& context,
                                MonotonicTime now) {
  const auto deadline = context.deadline();
  if (deadline == std::chrono::system_clock::time_point::max()) {
    return MonotonicTime::max();
  }
  const auto left = deadline - std::chrono::system_clock::now();
  // Far deadlines must not overflow the sum.
  if (left > std::chrono::hours(24 * 365)) return MonotonicTime::max();
  return now + std::chrono::duration_cast<MonotonicTime::duration>(left);
}

constexpr char kInternalFault[] =
    "a fault of the server; its log has the details";

}  // namespace

// One Localize in flight. Lives until gRPC is done with it.
class RelocalizationGrpcService::Call final : public grpc::ServerUnaryReactor {
 public:
  Call(const RelocalizationGrpcService& service,
       grpc::CallbackServerContext& context, const v1::LocalizeRequest& request,
       v1::LocalizeResponse& response)
      : service_(service),
        server_context_(context),
        request_(request),
        response_(response) {
    record_.rpc = "Localize";
    record_.peer = context.peer();
    context_.arrival = service.clock_.Now();
    context_.deadline = MonotonicDeadline(context, context_.arrival);
    context_.stop = stop_.get_token();
  }

  void Start() {
    if (!service_.workers_.TrySubmit([this] { Run(); })) TurnAway();
  }

 private:
  // gRPC calls this when the client cancels or goes away, and when the
  // deadline passes.
  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override { delete this; }

  void TurnAway() {
    const double backlog_ms = service_.workers_.BacklogEstimate_ms();
    const double pushback_ms =
        std::clamp(backlog_ms, kMinPushback_ms, kMaxPushback_ms);
    server_context_.AddTrailingMetadata(
        "grpc-retry-pushback-ms", absl::StrCat(static_cast<int>(pushback_ms)));
    record_.scene = request_.scene().substr(0, kLongestName);
    End(absl::UnavailableError("overloaded: the queue is full"));
  }

  void Run() {
    absl::StatusOr<v1::LocalizeResponse> response =
        absl::InternalError(kInternalFault);
    try {
      response = service_.rpc_.Handle(request_, context_, record_);
    } catch (const std::exception& error) {
      record_.internal_error = error.what();
    } catch (...) {
      record_.internal_error = "an exception of unknown type";
    }
    if (response.ok()) response_ = std::move(*response);
    End(response.status());
  }

  // Nothing of *this may be touched after Finish.
  void End(const absl::Status& status) {
    record_.status = status;
    if (record_.timings.total_ms == 0) {
      record_.timings.total_ms =
          MillisecondsBetween(context_.arrival, service_.clock_.Now());
    }
    service_.observer_.OnCall(record_);
    Finish(ToGrpc(status));
  }

  const RelocalizationGrpcService& service_;
  grpc::CallbackServerContext& server_context_;
  const v1::LocalizeRequest& request_;
  v1::LocalizeResponse& response_;
  std::stop_source stop_;
  CallContext context_;
  CallRecord record_;
};

grpc::ServerUnaryReactor* RelocalizationGrpcService::Localize(
    grpc::CallbackServerContext* context, const v1::LocalizeRequest* request,
    v1::LocalizeResponse* response) {
  Call* call = new Call(*this, *context, *request, *response);
  call->Start();
  return call;
}

grpc::ServerUnaryReactor* SceneGrpcService::ListScenes(
    grpc::CallbackServerContext* context, const v1::ListScenesRequest*,
    v1::ListScenesResponse* response) {
  CallRecord record;
  record.rpc = "ListScenes";
  record.peer = context->peer();
  const MonotonicTime start = clock_.Now();
  *response = treeline::ListScenes(repository_);
  record.timings.total_ms = MillisecondsBetween(start, clock_.Now());
  observer_.OnCall(record);
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

grpc::ServerUnaryReactor* SceneGrpcService::GetScene(
    grpc::CallbackServerContext* context, const v1::GetSceneRequest* request,
    v1::GetSceneResponse* response) {
  CallRecord record;
  record.rpc = "GetScene";
  record.peer = context->peer();
  record.scene = request->scene().substr(0, kLongestName);
  const MonotonicTime start = clock_.Now();
  absl::StatusOr<v1::GetSceneResponse> answer =
      treeline::GetScene(repository_, *request);
  if (answer.ok()) *response = std::move(*answer);
  record.status = answer.status();
  record.timings.total_ms = MillisecondsBetween(start, clock_.Now());
  observer_.OnCall(record);
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(ToGrpc(record.status));
  return reactor;
}

}  // namespace treeline
