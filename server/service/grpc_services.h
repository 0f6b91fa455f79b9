// The RPCs behind gRPC's callback API. Each asks the dispatcher whether its
// call is let in, then reads the request, and hands it over.
#ifndef SERVER_SERVICE_GRPC_SERVICES_H_
#define SERVER_SERVICE_GRPC_SERVICES_H_

#include "common/grpc_server/raw_service.h"
#include "server/service/deadline_timer.h"
#include "server/service/dispatcher.h"
#include "server/service/grpc_call.h"
#include "server/service/localize_stream.h"

namespace treeline::service {

class RelocalizationGrpcService final : public grpc_server::RawService {
 public:
  // All must outlive the server that the service is registered with.
  RelocalizationGrpcService(Dispatcher& dispatcher, const CallSource& source);

  // Ends the streams once they have answered what they read.
  void DrainStreams() { streams_.Drain(); }

 private:
  Dispatcher& dispatcher_;
  const CallSource source_;
  DeadlineTimer timer_;
  LocalizeStreams streams_;
};

class SceneGrpcService final : public grpc_server::RawService {
 public:
  SceneGrpcService(Dispatcher& dispatcher, const CallSource& source);

 private:
  Dispatcher& dispatcher_;
  const CallSource source_;
  DeadlineTimer timer_;
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_GRPC_SERVICES_H_
