#include "nav_agent/service/connect_services.h"

#include <string>

#include "absl/strings/str_cat.h"

namespace treeline::agent_service {
namespace {

template <typename Message>
class ConnectSink final : public MessageSink<Message> {
 public:
  explicit ConnectSink(connect_rpc::ConnectStream& stream) : stream_(stream) {}

  bool Write(const Message& message) override { return stream_.Write(message); }
  bool IsGone() override { return stream_.IsGone(); }

 private:
  connect_rpc::ConnectStream& stream_;
};

// `method`: a pointer to a member of Calls, const or not, that takes a Request.
template <typename Request, typename Calls, typename Method>
void AddUnary(absl::string_view service, absl::string_view name, Calls& calls,
              Method method, connect_rpc::ConnectRouter& router) {
  router.AddUnary<Request>(
      absl::StrCat("/treeline.v1.", service, "/", name),
      [&calls, method](const connect_rpc::ConnectCall& /*call*/,
                       const Request& request) {
        return (calls.*method)(request);
      });
}

template <typename Request, typename Response, typename Calls>
void AddStream(absl::string_view service, absl::string_view name, Calls& calls,
               absl::Status (Calls::*method)(const Request&,
                                             MessageSink<Response>&),
               connect_rpc::ConnectRouter& router) {
  router.AddStream<Request, Response>(
      absl::StrCat("/treeline.v1.", service, "/", name),
      [&calls, method](const Request& request,
                       connect_rpc::ConnectStream& stream) {
        ConnectSink<Response> sink(stream);
        return (calls.*method)(request, sink);
      });
}

}  // namespace

void AddNavigationCalls(NavigationCalls& calls,
                        connect_rpc::ConnectRouter& router) {
  using Calls = NavigationCalls;
  constexpr char kService[] = "NavigationService";
  AddStream(kService, "Navigate", calls, &Calls::Navigate, router);
  AddStream(kService, "StreamState", calls, &Calls::StreamState, router);
  AddStream(kService, "RunRoute", calls, &Calls::RunRoute, router);
  AddUnary<v1::ResumeRouteRequest>(kService, "ResumeRoute", calls,
                                   &Calls::ResumeRoute, router);
  AddUnary<v1::CancelRouteRequest>(kService, "CancelRoute", calls,
                                   &Calls::CancelRoute, router);
  AddUnary<v1::GetRoutesRequest>(kService, "GetRoutes", calls,
                                 &Calls::GetRoutes, router);
  AddUnary<v1::PutRoutesRequest>(kService, "PutRoutes", calls,
                                 &Calls::PutRoutes, router);
  AddUnary<v1::RemoveRoutesRequest>(kService, "RemoveRoutes", calls,
                                    &Calls::RemoveRoutes, router);
  AddUnary<v1::CancelRequest>(kService, "Cancel", calls, &Calls::Cancel,
                              router);
  AddUnary<v1::PauseRequest>(kService, "Pause", calls, &Calls::Pause, router);
  AddUnary<v1::ResumeRequest>(kService, "Resume", calls, &Calls::Resume,
                              router);
  AddUnary<v1::StopRequest>(kService, "Stop", calls, &Calls::Stop, router);
  AddUnary<v1::ReleaseRequest>(kService, "Release", calls, &Calls::Release,
                               router);
  AddUnary<v1::DriveRequest>(kService, "Drive", calls, &Calls::Drive, router);
  AddUnary<v1::GetInfoRequest>(kService, "GetInfo", calls, &Calls::GetInfo,
                               router);
  AddUnary<v1::GetMapsRequest>(kService, "GetMaps", calls, &Calls::GetMaps,
                               router);
  AddUnary<v1::GetZonesRequest>(kService, "GetZones", calls, &Calls::GetZones,
                                router);
  AddUnary<v1::PutZonesRequest>(kService, "PutZones", calls, &Calls::PutZones,
                                router);
  AddUnary<v1::RemoveZonesRequest>(kService, "RemoveZones", calls,
                                   &Calls::RemoveZones, router);
  AddUnary<v1::SetInitialPoseRequest>(kService, "SetInitialPose", calls,
                                      &Calls::SetInitialPose, router);
  AddUnary<v1::FindYourselfRequest>(kService, "FindYourself", calls,
                                    &Calls::FindYourself, router);
}

void AddDockingCalls(DockingCalls& calls, connect_rpc::ConnectRouter& router) {
  using Calls = DockingCalls;
  constexpr char kService[] = "DockingService";
  AddUnary<v1::GetDocksRequest>(kService, "GetDocks", calls, &Calls::GetDocks,
                                router);
  AddUnary<v1::PutDocksRequest>(kService, "PutDocks", calls, &Calls::PutDocks,
                                router);
  AddUnary<v1::RemoveDocksRequest>(kService, "RemoveDocks", calls,
                                   &Calls::RemoveDocks, router);
  AddStream(kService, "Dock", calls, &Calls::Dock, router);
  AddUnary<v1::UndockRequest>(kService, "Undock", calls, &Calls::Undock,
                              router);
}

void AddSimulationCalls(SimulationCalls& calls,
                        connect_rpc::ConnectRouter& router) {
  using Calls = SimulationCalls;
  constexpr char kService[] = "SimulationService";
  AddUnary<v1::KidnapRequest>(kService, "Kidnap", calls, &Calls::Kidnap,
                              router);
  AddUnary<v1::AddObstacleRequest>(kService, "AddObstacle", calls,
                                   &Calls::AddObstacle, router);
  AddUnary<v1::RemoveObstacleRequest>(kService, "RemoveObstacle", calls,
                                      &Calls::RemoveObstacle, router);
  AddUnary<v1::InjectFaultRequest>(kService, "InjectFault", calls,
                                   &Calls::InjectFault, router);
}

}  // namespace treeline::agent_service
