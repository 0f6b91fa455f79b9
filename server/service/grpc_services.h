// The RPCs behind gRPC's callback API: each hands its call to the dispatcher.
#ifndef SERVER_SERVICE_GRPC_SERVICES_H_
#define SERVER_SERVICE_GRPC_SERVICES_H_

#include "server/service/dispatcher.h"
#include "server/service/grpc_call.h"
#include "server/service/localize_stream.h"
#include "treeline/v1/relocalization.grpc.pb.h"
#include "treeline/v1/scenes.grpc.pb.h"

namespace treeline::service {

class RelocalizationGrpcService final
    : public v1::RelocalizationService::CallbackService {
 public:
  // All must outlive the server that the service is registered with.
  RelocalizationGrpcService(Dispatcher& dispatcher, const CallSource& source)
      : dispatcher_(dispatcher), source_(source) {}

  grpc::ServerUnaryReactor* Localize(grpc::CallbackServerContext* context,
                                     const v1::LocalizeRequest* request,
                                     v1::LocalizeResponse* response) override;
  grpc::ServerBidiReactor<v1::LocalizeStreamRequest,
                          v1::LocalizeStreamResponse>*
  LocalizeStream(grpc::CallbackServerContext* context) override;

  // Ends the streams once they have answered what they read.
  void DrainStreams() { streams_.Drain(); }

 private:
  Dispatcher& dispatcher_;
  const CallSource source_;
  LocalizeStreams streams_;
};

class SceneGrpcService final : public v1::SceneService::CallbackService {
 public:
  SceneGrpcService(Dispatcher& dispatcher, const CallSource& source)
      : dispatcher_(dispatcher), source_(source) {}

  grpc::ServerUnaryReactor* ListScenes(
      grpc::CallbackServerContext* context,
      const v1::ListScenesRequest* request,
      v1::ListScenesResponse* response) override;
  grpc::ServerUnaryReactor* GetScene(grpc::CallbackServerContext* context,
                                     const v1::GetSceneRequest* request,
                                     v1::GetSceneResponse* response) override;
  grpc::ServerUnaryReactor* LoadScene(grpc::CallbackServerContext* context,
                                      const v1::LoadSceneRequest* request,
                                      v1::LoadSceneResponse* response) override;
  grpc::ServerUnaryReactor* UnloadScene(
      grpc::CallbackServerContext* context,
      const v1::UnloadSceneRequest* request,
      v1::UnloadSceneResponse* response) override;

 private:
  Dispatcher& dispatcher_;
  const CallSource source_;
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_GRPC_SERVICES_H_
