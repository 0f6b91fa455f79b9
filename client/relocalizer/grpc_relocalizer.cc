#include "client/relocalizer/grpc_relocalizer.h"

#include <grpcpp/client_context.h>

#include <memory>
#include <string>
#include <utility>

#include "absl/strings/string_view.h"
#include "client/relocalizer/channel.h"
#include "client/relocalizer/convert.h"
#include "client/relocalizer/grpc_localize_stream.h"
#include "client/relocalizer/relocalizer.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "common/wire/status.h"
#include "treeline/v1/relocalization.grpc.pb.h"
#include "treeline/v1/scenes.grpc.pb.h"

namespace treeline::relocalizer {
namespace {

// A call's context: its deadline, and its cancellation while it lasts.
class Context {
 public:
  // scene: that the call is about, if it is about one.
  Context(const Connection& connection, const CallOptions& options,
          absl::string_view scene = {})
      : on_stop_(options.stop, [this] { context_.TryCancel(); }) {
    connection.Prepare(context_, scene, options.traceparent);
    context_.set_deadline(std::chrono::system_clock::now() + options.timeout);
  }
  grpc::ClientContext* get() { return &context_; }

 private:
  grpc::ClientContext context_;
  std::stop_callback<std::function<void()>> on_stop_;
};

class GrpcRelocalizer final : public Relocalizer {
 public:
  explicit GrpcRelocalizer(Connection connection)
      : connection_(std::move(connection)),
        relocalization_(
            v1::RelocalizationService::NewStub(connection_.channel())),
        scenes_(v1::SceneService::NewStub(connection_.channel())) {}

  absl::StatusOr<LocalizeAnswer> Localize(const LocalizeQuery& query,
                                          const CallOptions& options) override {
    const base::SteadyClock clock;
    const base::MonotonicTime start = clock.Now();
    Context context(connection_, options, query.scene);
    v1::LocalizeResponse response;
    TL_RETURN_IF_ERROR(wire::FromGrpc(
        relocalization_->Localize(context.get(), ToProto(query), &response)));
    TL_ASSIGN_OR_RETURN(LocalizeAnswer answer, FromProto(response));
    answer.round_trip_ms = base::MillisecondsBetween(start, clock.Now());
    return answer;
  }

  absl::StatusOr<std::vector<SceneDescription>> ListScenes(
      const CallOptions& options) override {
    Context context(connection_, options);
    v1::ListScenesResponse response;
    TL_RETURN_IF_ERROR(
        wire::FromGrpc(scenes_->ListScenes(context.get(), {}, &response)));
    std::vector<SceneDescription> scenes;
    for (const v1::SceneInfo& info : response.scenes()) {
      TL_ASSIGN_OR_RETURN(SceneDescription scene, FromProto(info));
      scenes.push_back(std::move(scene));
    }
    return scenes;
  }

  absl::StatusOr<SceneDescription> GetScene(
      const std::string& scene, const CallOptions& options) override {
    Context context(connection_, options, scene);
    v1::GetSceneRequest request;
    request.set_scene(scene);
    v1::GetSceneResponse response;
    TL_RETURN_IF_ERROR(
        wire::FromGrpc(scenes_->GetScene(context.get(), request, &response)));
    return FromProto(response.scene());
  }

  absl::StatusOr<SceneDescription> LoadScene(
      const std::string& scene, const std::string& model_version,
      const CallOptions& options) override {
    Context context(connection_, options);
    v1::LoadSceneRequest request;
    request.set_scene(scene);
    request.set_model_version(model_version);
    v1::LoadSceneResponse response;
    TL_RETURN_IF_ERROR(
        wire::FromGrpc(scenes_->LoadScene(context.get(), request, &response)));
    return FromProto(response.scene());
  }

  absl::StatusOr<SceneDescription> UnloadScene(
      const std::string& scene, const std::string& model_version,
      const CallOptions& options) override {
    Context context(connection_, options);
    v1::UnloadSceneRequest request;
    request.set_scene(scene);
    request.set_model_version(model_version);
    v1::UnloadSceneResponse response;
    TL_RETURN_IF_ERROR(wire::FromGrpc(
        scenes_->UnloadScene(context.get(), request, &response)));
    return FromProto(response.scene());
  }

  std::unique_ptr<LocalizeStream> OpenStream(
      const StreamOptions& options) override {
    return OpenGrpcStream(connection_, *relocalization_, options);
  }

 private:
  const Connection connection_;
  const std::unique_ptr<v1::RelocalizationService::Stub> relocalization_;
  const std::unique_ptr<v1::SceneService::Stub> scenes_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Relocalizer>> ConnectRelocalizer(
    const ConnectOptions& options) {
  TL_ASSIGN_OR_RETURN(Connection connection, Connection::Open(options));
  return std::make_unique<GrpcRelocalizer>(std::move(connection));
}

}  // namespace treeline::relocalizer
