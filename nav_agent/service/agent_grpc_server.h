// The listener of the agent's gRPC services.
#ifndef NAV_AGENT_SERVICE_AGENT_GRPC_SERVER_H_
#define NAV_AGENT_SERVICE_AGENT_GRPC_SERVER_H_

#include <functional>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/service/agent_commands.h"

namespace treeline::agent_service {

struct AgentGrpcOptions {
  // "HOST:PORT"; port 0 takes any that is free.
  std::string listen = "127.0.0.1:50061";
  // Whether other machines may reach it, though nothing is encrypted and
  // whoever reaches it drives the robot.
  bool insecure_any_address = false;
  // Streams at a time, 1..1000.
  int max_streams = 32;
  // Is told of connections that were cut off since they flooded it, at most
  // once a second, from any thread. Empty: nobody is.
  std::function<void(const std::string& message)> report = nullptr;

  absl::Status Validate() const;
};

// NavigationService, grpc.health.v1, reflection and, of a simulated robot,
// SimulationService. Serves until it is destroyed; the hub must be closed
// before, so that streams end.
class AgentGrpcServer {
 public:
  // INVALID_ARGUMENT: options. UNAVAILABLE: the address cannot be bound.
  static absl::StatusOr<std::unique_ptr<AgentGrpcServer>> Start(
      AgentCommands& commands, const AgentGrpcOptions& options);
  ~AgentGrpcServer();

  // HOST:PORT with the port that was bound.
  const std::string& address() const;

 private:
  struct Parts;
  explicit AgentGrpcServer(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_AGENT_GRPC_SERVER_H_
