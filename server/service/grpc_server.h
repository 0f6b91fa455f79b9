// The service on a socket.
#ifndef SERVER_SERVICE_GRPC_SERVER_H_
#define SERVER_SERVICE_GRPC_SERVER_H_

#include <grpcpp/security/server_credentials.h>

#include <chrono>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/byte_budget.h"
#include "common/base/clock.h"
#include "common/flood_guard/flood_guard.h"
#include "server/repository/scene_repository.h"
#include "server/service/dispatcher.h"
#include "server/service/grpc_call.h"

namespace treeline::service {

// Which of the services a listener has.
enum class ListenerKind {
  // RelocalizationService, SceneService.
  kPublic,
  // SceneService with what only operators may do, and channelz.
  kAdmin
};

struct GrpcServerOptions {
  ListenerKind kind = ListenerKind::kPublic;
  // "HOST:PORT" with an IPv4 address, a bracketed IPv6 address or a name; port
  // 0 takes any that is free.
  std::string listen = "127.0.0.1:50051";
  // Whether `listen` may be reached from other machines although nothing is
  // encrypted and nobody is authenticated.
  bool insecure_any_address = false;
  // Null: plain text.
  std::shared_ptr<grpc::ServerCredentials> credentials = nullptr;
  // Names in the certificate that a client has shown and TLS has verified;
  // empty: calls have none.
  CertificateNamesOf certificate_names = {};
  // Largest request, 1..1024.
  int max_message_mib = 32;
  // What requests may hold together while they arrive, 1..1048576; 0: 4 of the
  // largest. Beyond it gRPC ends calls.
  int max_buffered_mib = 0;
  // What requests are held by from then to their answers, and large answers
  // from then until their clients have taken them; nullptr: without a bound.
  // Must outlive the server.
  base::ByteBudget* budget = nullptr;
  base::ByteBudget* answers = nullptr;
  // After this a connection is asked to close, so that a balancer and new
  // replicas get their share; seconds, 1..1e6; 0: never. Calls on it finish;
  // streams have `connection_grace_s`.
  int max_connection_age_s = 600;
  int connection_grace_s = 60;
  // Cuts off connections that flood it; null: none are.
  std::shared_ptr<flood_guard::FloodGuard> guard = nullptr;

  absl::Status Validate() const;
};

// Serves from construction to Stop(), with grpc.health.v1 and reflection.
// Messages must not be compressed: gRPC inflates without a bound, and images
// are compressed already.
//
// Health knows "", the whole server, and, for who may localize,
// "treeline.scene.<name>" for each scene: SERVING if the scene answers or would
// be loaded by its first query, NOT_SERVING if it failed.
class GrpcServer {
 public:
  // INVALID_ARGUMENT: options. UNAVAILABLE: the address cannot be bound, with
  // the system's reason. All references must outlive the server.
  static absl::StatusOr<std::unique_ptr<GrpcServer>> Start(
      Dispatcher& dispatcher, const repository::SceneRepository& repository,
      const GrpcServerOptions& options, const base::Clock& clock);
  // Stops without waiting for calls in flight: they are cancelled.
  ~GrpcServer();

  // HOST:PORT with the port that was bound.
  const std::string& address() const;

  // Health answers NOT_SERVING from now on, so that balancers look elsewhere,
  // and streams end when they have answered what they have read; calls are
  // still answered.
  void AnnounceStop();

  // Closes the listener, waits up to `grace` for the calls in flight, cancels
  // the rest, and returns when the last has ended.
  void Stop(std::chrono::milliseconds grace);

 private:
  struct Parts;
  explicit GrpcServer(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_GRPC_SERVER_H_
