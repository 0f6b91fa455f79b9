// The RPCs behind gRPC's callback API: admission, deadlines, cancellation.
#ifndef SERVER_SERVICE_GRPC_SERVICES_H_
#define SERVER_SERVICE_GRPC_SERVICES_H_

#include "server/repository/scene_repository.h"
#include "server/service/call_observer.h"
#include "server/service/localize_rpc.h"
#include "server/service/worker_pool.h"
#include "treeline/v1/relocalization.grpc.pb.h"
#include "treeline/v1/scenes.grpc.pb.h"

namespace treeline {

// Hands each call to a worker, or turns it away with UNAVAILABLE and, in the
// trailing metadata, grpc-retry-pushback-ms: when to try again.
class RelocalizationGrpcService final
    : public v1::RelocalizationService::CallbackService {
 public:
  // All must outlive the server that the service is registered with.
  RelocalizationGrpcService(const LocalizeRpc& rpc, WorkerPool& workers,
                            CallObserver& observer, const Clock& clock)
      : rpc_(rpc), workers_(workers), observer_(observer), clock_(clock) {}

  grpc::ServerUnaryReactor* Localize(grpc::CallbackServerContext* context,
                                     const v1::LocalizeRequest* request,
                                     v1::LocalizeResponse* response) override;

 private:
  class Call;

  const LocalizeRpc& rpc_;
  WorkerPool& workers_;
  CallObserver& observer_;
  const Clock& clock_;
};

// Answers at once, on gRPC's thread: there is nothing to compute, and an
// operator wants an answer from a server that is overloaded too.
class SceneGrpcService final : public v1::SceneService::CallbackService {
 public:
  SceneGrpcService(const SceneRepository& repository, CallObserver& observer,
                   const Clock& clock)
      : repository_(repository), observer_(observer), clock_(clock) {}

  grpc::ServerUnaryReactor* ListScenes(
      grpc::CallbackServerContext* context,
      const v1::ListScenesRequest* request,
      v1::ListScenesResponse* response) override;
  grpc::ServerUnaryReactor* GetScene(grpc::CallbackServerContext* context,
                                     const v1::GetSceneRequest* request,
                                     v1::GetSceneResponse* response) override;

 private:
  const SceneRepository& repository_;
  CallObserver& observer_;
  const Clock& clock_;
};

}  // namespace treeline

#endif  // SERVER_SERVICE_GRPC_SERVICES_H_
