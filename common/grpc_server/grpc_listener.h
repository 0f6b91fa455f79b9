// A gRPC server on a socket: what is the same for all of ours.
#ifndef COMMON_GRPC_SERVER_GRPC_LISTENER_H_
#define COMMON_GRPC_SERVER_GRPC_LISTENER_H_

#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/flood_guard/flood_guard.h"
#include "common/flood_guard/guarded_sockets.h"

namespace treeline::grpc_server {

// A plugin of gRPC, which brings a service along. They are global: a builder
// has all that were enabled before it was made.
struct GrpcPlugin {
  // As it calls itself: "channelz".
  std::string name;
  // Is called once in a process.
  void (*enable)();
};

struct GrpcListenerOptions {
  // "HOST:PORT"; port 0 takes any that is free. Whether other machines may
  // reach it is for the caller to decide.
  std::string listen;
  // Null: plain text.
  std::shared_ptr<grpc::ServerCredentials> credentials = nullptr;
  // gRPC's own grpc.health.v1.
  bool default_health = true;
  // No others are served, whatever the process has enabled.
  std::vector<GrpcPlugin> plugins = {};
  int max_message_bytes = 4 << 20;
  // Whether messages may be compressed; gRPC inflates them without a bound. If
  // not, clients are told, and what they compress is UNIMPLEMENTED.
  bool allow_compression = true;
  // What requests may hold together while they arrive, bytes; 0: no limit.
  size_t max_buffered_bytes = 0;
  // Threads of gRPC; 0: no limit.
  int max_threads = 0;
  // Calls at a time on one connection; 0: no limit.
  int max_calls_of_connection = 0;
  // A peer that has been silent for so long is asked whether it lives, and cut
  // off if it does not say so: a stream to it must not wait for ever. And
  // whether it is asked while it has no call.
  int keepalive_time_ms = 60'000;
  int keepalive_timeout_ms = 20'000;
  bool keepalive_without_calls = false;
  // After this a connection is asked to close, seconds; 0: never. Its calls
  // have `connection_grace_s` to end.
  int max_connection_age_s = 0;
  int connection_grace_s = 60;
  // Cuts off connections that flood the listener; null: none are. Listeners
  // may share one, and it lives as long as their connections.
  std::shared_ptr<flood_guard::FloodGuard> guard = nullptr;
};

struct GrpcListener {
  // HOST:PORT with the port that was bound.
  std::string address;
  // Null: there is no guard.
  std::unique_ptr<flood_guard::GuardedPort> guarded_port;
  // Never null. Its owner shuts it down.
  std::unique_ptr<grpc::Server> server;
};

// Serves from now on what `add_services` registers, and what the options add.
// No other program can share the port. INVALID_ARGUMENT: the address.
// UNAVAILABLE: it cannot be bound, with the system's reason.
absl::StatusOr<GrpcListener> StartGrpcListener(
    const GrpcListenerOptions& options,
    const std::function<void(grpc::ServerBuilder&)>& add_services);

}  // namespace treeline::grpc_server

#endif  // COMMON_GRPC_SERVER_GRPC_LISTENER_H_
