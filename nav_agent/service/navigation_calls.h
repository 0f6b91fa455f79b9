// The methods of NavigationService, whatever carries them: gRPC or Connect.
#ifndef NAV_AGENT_SERVICE_NAVIGATION_CALLS_H_
#define NAV_AGENT_SERVICE_NAVIGATION_CALLS_H_

#include <atomic>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/service/agent_commands.h"
#include "nav_agent/service/message_sink.h"
#include "treeline/v1/navigation.pb.h"

namespace treeline::agent_service {

// Thread-safe. Errors as the proto lists them, and as AgentCommands has them.
class NavigationCalls {
 public:
  // `commands` must outlive it. More streams than `max_streams` at a time:
  // RESOURCE_EXHAUSTED.
  NavigationCalls(AgentCommands& commands, int max_streams)
      : commands_(commands), max_streams_(max_streams) {}

  // Streams: CANCELLED when nobody hears `sink`, UNAVAILABLE when the hub is
  // closed.
  absl::Status Navigate(const v1::NavigateRequest& request,
                        MessageSink<v1::NavigateResponse>& sink);
  absl::Status StreamState(const v1::StreamStateRequest& request,
                           MessageSink<v1::StreamStateResponse>& sink);

  absl::StatusOr<v1::CancelResponse> Cancel(const v1::CancelRequest& request);
  absl::StatusOr<v1::PauseResponse> Pause(const v1::PauseRequest& request);
  absl::StatusOr<v1::ResumeResponse> Resume(const v1::ResumeRequest& request);
  absl::StatusOr<v1::StopResponse> Stop(const v1::StopRequest& request);
  absl::StatusOr<v1::ReleaseResponse> Release(
      const v1::ReleaseRequest& request);
  absl::StatusOr<v1::DriveResponse> Drive(const v1::DriveRequest& request);
  absl::StatusOr<v1::GetInfoResponse> GetInfo(
      const v1::GetInfoRequest& request) const;
  absl::StatusOr<v1::GetMapsResponse> GetMaps(
      const v1::GetMapsRequest& request) const;
  absl::StatusOr<v1::GetZonesResponse> GetZones(
      const v1::GetZonesRequest& request) const;
  absl::StatusOr<v1::PutZonesResponse> PutZones(
      const v1::PutZonesRequest& request);
  absl::StatusOr<v1::RemoveZonesResponse> RemoveZones(
      const v1::RemoveZonesRequest& request);
  absl::Status RunRoute(const v1::RunRouteRequest& request,
                        MessageSink<v1::RunRouteResponse>& sink);
  absl::StatusOr<v1::ResumeRouteResponse> ResumeRoute(
      const v1::ResumeRouteRequest& request);
  absl::StatusOr<v1::CancelRouteResponse> CancelRoute(
      const v1::CancelRouteRequest& request);
  absl::StatusOr<v1::GetRoutesResponse> GetRoutes(
      const v1::GetRoutesRequest& request) const;
  absl::StatusOr<v1::PutRoutesResponse> PutRoutes(
      const v1::PutRoutesRequest& request);
  absl::StatusOr<v1::RemoveRoutesResponse> RemoveRoutes(
      const v1::RemoveRoutesRequest& request);
  absl::StatusOr<v1::SetInitialPoseResponse> SetInitialPose(
      const v1::SetInitialPoseRequest& request);
  absl::StatusOr<v1::FindYourselfResponse> FindYourself(
      const v1::FindYourselfRequest& request);

 private:
  // As the newest state has it, with what was put or removed since.
  uint64_t RoutesRevision() const;

  AgentCommands& commands_;
  const int max_streams_;
  std::atomic<int> streams_ = 0;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_NAVIGATION_CALLS_H_
