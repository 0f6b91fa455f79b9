#include "server/service/grpc_services.h"

#include <stop_token>
#include <utility>

#include "server/service/grpc_call.h"

namespace treeline::service {
namespace {

// One unary call in flight. Lives until gRPC is done with it.
template <typename Request, typename Response>
class UnaryCall final : public grpc::ServerUnaryReactor {
 public:
  using Method = void (Dispatcher::*)(CallInfo, const Request&,
                                      Dispatcher::Done<Response>);

  UnaryCall(grpc::CallbackServerContext& context, Response& response)
      : context_(context), response_(response) {}

  void Start(Dispatcher& dispatcher, Method method, const Request& request,
             const char* rpc, const CallSource& source) {
    (dispatcher.*method)(CallInfoFrom(context_, rpc, source, stop_.get_token()),
                         request, [this](absl::StatusOr<Response> response) {
                           const absl::Status status = response.status();
                           if (status.ok()) response_ = *std::move(response);
                           Finish(FinishStatus(status, context_));
                         });
  }

 private:
  // gRPC calls this when the client cancels or goes away, and when the
  // deadline passes.
  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override { delete this; }

  grpc::CallbackServerContext& context_;
  Response& response_;
  std::stop_source stop_;
};

template <typename Request, typename Response>
grpc::ServerUnaryReactor* Begin(
    grpc::CallbackServerContext* context, const Request* request,
    Response* response, Dispatcher& dispatcher,
    typename UnaryCall<Request, Response>::Method method, const char* rpc,
    const CallSource& source) {
  auto* call = new UnaryCall<Request, Response>(*context, *response);
  call->Start(dispatcher, method, *request, rpc, source);
  return call;
}

}  // namespace

grpc::ServerUnaryReactor* RelocalizationGrpcService::Localize(
    grpc::CallbackServerContext* context, const v1::LocalizeRequest* request,
    v1::LocalizeResponse* response) {
  return Begin(context, request, response, dispatcher_, &Dispatcher::Localize,
               "Localize", source_);
}

grpc::ServerBidiReactor<v1::LocalizeStreamRequest, v1::LocalizeStreamResponse>*
RelocalizationGrpcService::LocalizeStream(
    grpc::CallbackServerContext* context) {
  return streams_.Begin(*context, dispatcher_, source_);
}

grpc::ServerUnaryReactor* SceneGrpcService::ListScenes(
    grpc::CallbackServerContext* context, const v1::ListScenesRequest* request,
    v1::ListScenesResponse* response) {
  return Begin(context, request, response, dispatcher_, &Dispatcher::ListScenes,
               "ListScenes", source_);
}

grpc::ServerUnaryReactor* SceneGrpcService::GetScene(
    grpc::CallbackServerContext* context, const v1::GetSceneRequest* request,
    v1::GetSceneResponse* response) {
  return Begin(context, request, response, dispatcher_, &Dispatcher::GetScene,
               "GetScene", source_);
}

grpc::ServerUnaryReactor* SceneGrpcService::LoadScene(
    grpc::CallbackServerContext* context, const v1::LoadSceneRequest* request,
    v1::LoadSceneResponse* response) {
  return Begin(context, request, response, dispatcher_, &Dispatcher::LoadScene,
               "LoadScene", source_);
}

grpc::ServerUnaryReactor* SceneGrpcService::UnloadScene(
    grpc::CallbackServerContext* context, const v1::UnloadSceneRequest* request,
    v1::UnloadSceneResponse* response) {
  return Begin(context, request, response, dispatcher_,
               &Dispatcher::UnloadScene, "UnloadScene", source_);
}

}  // namespace treeline::service
