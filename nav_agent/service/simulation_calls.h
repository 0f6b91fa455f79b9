// The methods of SimulationService, whatever carries them: gRPC or Connect.
#ifndef NAV_AGENT_SERVICE_SIMULATION_CALLS_H_
#define NAV_AGENT_SERVICE_SIMULATION_CALLS_H_

#include "absl/status/statusor.h"
#include "nav_agent/service/agent_commands.h"
#include "treeline/v1/navigation.pb.h"

namespace treeline::agent_service {

// Thread-safe. Errors as the proto lists them, and as AgentCommands has them.
class SimulationCalls {
 public:
  // `commands` must outlive it.
  explicit SimulationCalls(AgentCommands& commands) : commands_(commands) {}

  absl::StatusOr<v1::KidnapResponse> Kidnap(const v1::KidnapRequest& request);
  absl::StatusOr<v1::AddObstacleResponse> AddObstacle(
      const v1::AddObstacleRequest& request);
  absl::StatusOr<v1::RemoveObstacleResponse> RemoveObstacle(
      const v1::RemoveObstacleRequest& request);
  absl::StatusOr<v1::InjectFaultResponse> InjectFault(
      const v1::InjectFaultRequest& request);

 private:
  AgentCommands& commands_;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_SIMULATION_CALLS_H_
