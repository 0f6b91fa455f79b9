// Relocalizer over gRPC.
#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/create_channel.h>

#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/relocalizer/convert.h"
#include "client/relocalizer/relocalizer.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "common/wire/status.h"
#include "treeline/v1/relocalization.grpc.pb.h"
#include "treeline/v1/scenes.grpc.pb.h"

namespace treeline {
namespace {

// A request larger than this buffer is sent once and never retried; gRPC's
// default of 256 KiB is less than an ordinary frame with depth.
constexpr int kRetryBufferBytes = 16 << 20;

// gRPC's service configuration: calls go to every address in turn, and are
// tried again while the answer is UNAVAILABLE.
std::string ServiceConfig(int max_attempts) {
  constexpr char kRetryPolicy[] =
      R"(, "retryPolicy": {"maxAttempts": %d, "initialBackoff": "0.05s",)"
      R"( "maxBackoff": "1s", "backoffMultiplier": 3,)"
      R"( "retryableStatusCodes": ["UNAVAILABLE"]})";
  const std::string retry_policy =
      max_attempts > 1 ? absl::StrFormat(kRetryPolicy, max_attempts) : "";
  return absl::StrCat(
      R"({"loadBalancingConfig": [{"round_robin": {}}], "methodConfig": [)",
      R"({"name": [{"service": "treeline.v1.RelocalizationService"},)",
      R"( {"service": "treeline.v1.SceneService"}])", retry_policy, "}]}");
}

// A call's context: its deadline, and its cancellation while it lasts.
class Context {
 public:
  explicit Context(const CallOptions& options)
      : on_stop_(options.stop, [this] { context_.TryCancel(); }) {
    context_.set_deadline(std::chrono::system_clock::now() + options.timeout);
  }
  grpc::ClientContext* get() { return &context_; }

 private:
  grpc::ClientContext context_;
  std::stop_callback<std::function<void()>> on_stop_;
};

class GrpcRelocalizer final : public Relocalizer {
 public:
  explicit GrpcRelocalizer(const std::shared_ptr<grpc::Channel>& channel)
      : relocalization_(v1::RelocalizationService::NewStub(channel)),
        scenes_(v1::SceneService::NewStub(channel)) {}

  absl::StatusOr<LocalizeAnswer> Localize(const LocalizeQuery& query,
                                          const CallOptions& options) override {
    const SteadyClock clock;
    const MonotonicTime start = clock.Now();
    Context context(options);
    v1::LocalizeResponse response;
    TL_RETURN_IF_ERROR(FromGrpc(
        relocalization_->Localize(context.get(), ToProto(query), &response)));
    TL_ASSIGN_OR_RETURN(LocalizeAnswer answer, FromProto(response));
    answer.round_trip_ms = MillisecondsBetween(start, clock.Now());
    return answer;
  }

  absl::StatusOr<std::vector<SceneDescription>> ListScenes(
      const CallOptions& options) override {
    Context context(options);
    v1::ListScenesResponse response;
    TL_RETURN_IF_ERROR(
        FromGrpc(scenes_->ListScenes(context.get(), {}, &response)));
    std::vector<SceneDescription> scenes;
    for (const v1::SceneInfo& info : response.scenes()) {
      TL_ASSIGN_OR_RETURN(SceneDescription scene, FromProto(info));
      scenes.push_back(std::move(scene));
    }
    return scenes;
  }

  absl::StatusOr<SceneDescription> GetScene(
      const std::string& scene, const CallOptions& options) override {
    Context context(options);
    v1::GetSceneRequest request;
    request.set_scene(scene);
    v1::GetSceneResponse response;
    TL_RETURN_IF_ERROR(
        FromGrpc(scenes_->GetScene(context.get(), request, &response)));
    return FromProto(response.scene());
  }

 private:
  const std::unique_ptr<v1::RelocalizationService::Stub> relocalization_;
  const std::unique_ptr<v1::SceneService::Stub> scenes_;
};

}  // namespace

absl::Status ConnectOptions::Validate() const {
  if (server.empty()) {
    return absl::InvalidArgumentError(
        "no server given; for instance "
        "127.0.0.1:50051");
  }
  if (max_attempts < 1 || max_attempts > 5) {
    return absl::InvalidArgumentError(
        absl::StrCat("max_attempts is ", max_attempts, "; it must be 1..5"));
  }
  if (max_message_mib < 1 || max_message_mib > 1024) {
    return absl::InvalidArgumentError(absl::StrCat(
        "max_message_mib is ", max_message_mib, "; it must be 1..1024"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<Relocalizer>> ConnectRelocalizer(
    const ConnectOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  grpc::ChannelArguments arguments;
  arguments.SetServiceConfigJSON(ServiceConfig(options.max_attempts));
  arguments.SetInt(GRPC_ARG_PER_RPC_RETRY_BUFFER_SIZE, kRetryBufferBytes);
  arguments.SetMaxReceiveMessageSize(options.max_message_mib << 20);
  arguments.SetMaxSendMessageSize(options.max_message_mib << 20);
  return std::make_unique<GrpcRelocalizer>(grpc::CreateCustomChannel(
      options.server, grpc::InsecureChannelCredentials(), arguments));
}

}  // namespace treeline
