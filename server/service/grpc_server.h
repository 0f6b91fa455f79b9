// The service on a socket.
#ifndef SERVER_SERVICE_GRPC_SERVER_H_
#define SERVER_SERVICE_GRPC_SERVER_H_

#include <chrono>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/image/decode.h"
#include "server/repository/scene_repository.h"
#include "server/service/call_observer.h"

namespace treeline {

struct GrpcServerOptions {
  // "HOST:PORT" with an IPv4 address, a bracketed IPv6 address or a name; port
  // 0 takes any that is free.
  std::string listen = "127.0.0.1:50051";
  // Whether `listen` may be reached from other machines although nothing is
  // encrypted and nobody is authenticated.
  bool insecure_any_address = false;
  // Queries computed at a time, 1..1024; 0: one per processor.
  int workers = 0;
  // Queries that may wait for a worker, 1..100000.
  int queue = 64;
  // Largest request, 1..1024.
  int max_message_mib = 32;
  DecodeLimits decode_limits = {};

  absl::Status Validate() const;
};

// Serves RelocalizationService, SceneService, grpc.health.v1 and reflection
// from construction to Stop().
class GrpcServer {
 public:
  // INVALID_ARGUMENT: options. UNAVAILABLE: the address cannot be bound, with
  // the system's reason. All references must outlive the server.
  static absl::StatusOr<std::unique_ptr<GrpcServer>> Start(
      SceneRepository& repository, const GrpcServerOptions& options,
      CallObserver& observer, const Clock& clock);
  // Stops without waiting for calls in flight: they are cancelled.
  ~GrpcServer();

  // HOST:PORT with the port that was bound.
  const std::string& address() const;

  // Health answers NOT_SERVING from now on, so that balancers look elsewhere;
  // calls are still answered.
  void AnnounceStop();

  // Closes the listener, waits up to `grace` for the calls in flight, cancels
  // the rest, and returns when the last has ended.
  void Stop(std::chrono::milliseconds grace);

 private:
  struct Parts;
  explicit GrpcServer(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace treeline

#endif  // SERVER_SERVICE_GRPC_SERVER_H_
