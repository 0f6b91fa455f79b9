// The methods of DockingService, whatever carries them: gRPC or Connect.
#ifndef NAV_AGENT_SERVICE_DOCKING_CALLS_H_
#define NAV_AGENT_SERVICE_DOCKING_CALLS_H_

#include <atomic>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/service/agent_commands.h"
#include "nav_agent/service/message_sink.h"
#include "treeline/v1/docks.pb.h"

namespace treeline::agent_service {

// Thread-safe. Errors as the proto lists them, and as AgentCommands has them.
class DockingCalls {
 public:
  // `commands` must outlive it. More streams than `max_streams` at a time:
  // RESOURCE_EXHAUSTED.
  DockingCalls(AgentCommands& commands, int max_streams)
      : commands_(commands), max_streams_(max_streams) {}

  absl::StatusOr<v1::GetDocksResponse> GetDocks(
      const v1::GetDocksRequest& request) const;
  absl::StatusOr<v1::PutDocksResponse> PutDocks(
      const v1::PutDocksRequest& request);
  absl::StatusOr<v1::RemoveDocksResponse> RemoveDocks(
      const v1::RemoveDocksRequest& request);
  // As NavigationCalls' streams.
  absl::Status Dock(const v1::DockRequest& request,
                    MessageSink<v1::DockResponse>& sink);
  absl::StatusOr<v1::UndockResponse> Undock(const v1::UndockRequest& request);

 private:
  AgentCommands& commands_;
  const int max_streams_;
  std::atomic<int> streams_ = 0;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_DOCKING_CALLS_H_
