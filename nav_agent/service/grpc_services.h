// NavigationService, DockingService and SimulationService over gRPC.
#ifndef NAV_AGENT_SERVICE_GRPC_SERVICES_H_
#define NAV_AGENT_SERVICE_GRPC_SERVICES_H_

#include "nav_agent/service/docking_calls.h"
#include "nav_agent/service/navigation_calls.h"
#include "nav_agent/service/simulation_calls.h"
#include "treeline/v1/docks.grpc.pb.h"
#include "treeline/v1/navigation.grpc.pb.h"

namespace treeline::agent_service {

// Each call has a thread. Streams are bounded, and end with the hub.
class NavigationGrpcService final : public v1::NavigationService::Service {
 public:
  // `commands` must outlive the server that this is registered with.
  NavigationGrpcService(AgentCommands& commands, int max_streams)
      : calls_(commands, max_streams) {}

  grpc::Status Navigate(
      grpc::ServerContext* context, const v1::NavigateRequest* request,
      grpc::ServerWriter<v1::NavigateResponse>* writer) override;
  grpc::Status Cancel(grpc::ServerContext* context,
                      const v1::CancelRequest* request,
                      v1::CancelResponse* response) override;
  grpc::Status Pause(grpc::ServerContext* context,
                     const v1::PauseRequest* request,
                     v1::PauseResponse* response) override;
  grpc::Status Resume(grpc::ServerContext* context,
                      const v1::ResumeRequest* request,
                      v1::ResumeResponse* response) override;
  grpc::Status Stop(grpc::ServerContext* context,
                    const v1::StopRequest* request,
                    v1::StopResponse* response) override;
  grpc::Status Release(grpc::ServerContext* context,
                       const v1::ReleaseRequest* request,
                       v1::ReleaseResponse* response) override;
  grpc::Status Drive(grpc::ServerContext* context,
                     const v1::DriveRequest* request,
                     v1::DriveResponse* response) override;
  grpc::Status StreamState(
      grpc::ServerContext* context, const v1::StreamStateRequest* request,
      grpc::ServerWriter<v1::StreamStateResponse>* writer) override;
  grpc::Status GetInfo(grpc::ServerContext* context,
                       const v1::GetInfoRequest* request,
                       v1::GetInfoResponse* response) override;
  grpc::Status GetMaps(grpc::ServerContext* context,
                       const v1::GetMapsRequest* request,
                       v1::GetMapsResponse* response) override;
  grpc::Status GetZones(grpc::ServerContext* context,
                        const v1::GetZonesRequest* request,
                        v1::GetZonesResponse* response) override;
  grpc::Status PutZones(grpc::ServerContext* context,
                        const v1::PutZonesRequest* request,
                        v1::PutZonesResponse* response) override;
  grpc::Status RemoveZones(grpc::ServerContext* context,
                           const v1::RemoveZonesRequest* request,
                           v1::RemoveZonesResponse* response) override;
  grpc::Status RunRoute(
      grpc::ServerContext* context, const v1::RunRouteRequest* request,
      grpc::ServerWriter<v1::RunRouteResponse>* writer) override;
  grpc::Status ResumeRoute(grpc::ServerContext* context,
                           const v1::ResumeRouteRequest* request,
                           v1::ResumeRouteResponse* response) override;
  grpc::Status CancelRoute(grpc::ServerContext* context,
                           const v1::CancelRouteRequest* request,
                           v1::CancelRouteResponse* response) override;
  grpc::Status GetRoutes(grpc::ServerContext* context,
                         const v1::GetRoutesRequest* request,
                         v1::GetRoutesResponse* response) override;
  grpc::Status PutRoutes(grpc::ServerContext* context,
                         const v1::PutRoutesRequest* request,
                         v1::PutRoutesResponse* response) override;
  grpc::Status RemoveRoutes(grpc::ServerContext* context,
                            const v1::RemoveRoutesRequest* request,
                            v1::RemoveRoutesResponse* response) override;
  grpc::Status SetInitialPose(grpc::ServerContext* context,
                              const v1::SetInitialPoseRequest* request,
                              v1::SetInitialPoseResponse* response) override;
  grpc::Status FindYourself(grpc::ServerContext* context,
                            const v1::FindYourselfRequest* request,
                            v1::FindYourselfResponse* response) override;

 private:
  NavigationCalls calls_;
};

// As NavigationGrpcService.
class DockingGrpcService final : public v1::DockingService::Service {
 public:
  DockingGrpcService(AgentCommands& commands, int max_streams)
      : calls_(commands, max_streams) {}

  grpc::Status GetDocks(grpc::ServerContext* context,
                        const v1::GetDocksRequest* request,
                        v1::GetDocksResponse* response) override;
  grpc::Status PutDocks(grpc::ServerContext* context,
                        const v1::PutDocksRequest* request,
                        v1::PutDocksResponse* response) override;
  grpc::Status RemoveDocks(grpc::ServerContext* context,
                           const v1::RemoveDocksRequest* request,
                           v1::RemoveDocksResponse* response) override;
  grpc::Status Dock(grpc::ServerContext* context,
                    const v1::DockRequest* request,
                    grpc::ServerWriter<v1::DockResponse>* writer) override;
  grpc::Status Undock(grpc::ServerContext* context,
                      const v1::UndockRequest* request,
                      v1::UndockResponse* response) override;

 private:
  DockingCalls calls_;
};

class SimulationGrpcService final : public v1::SimulationService::Service {
 public:
  explicit SimulationGrpcService(AgentCommands& commands) : calls_(commands) {}

  grpc::Status Kidnap(grpc::ServerContext* context,
                      const v1::KidnapRequest* request,
                      v1::KidnapResponse* response) override;
  grpc::Status AddObstacle(grpc::ServerContext* context,
                           const v1::AddObstacleRequest* request,
                           v1::AddObstacleResponse* response) override;
  grpc::Status RemoveObstacle(grpc::ServerContext* context,
                              const v1::RemoveObstacleRequest* request,
                              v1::RemoveObstacleResponse* response) override;
  grpc::Status InjectFault(grpc::ServerContext* context,
                           const v1::InjectFaultRequest* request,
                           v1::InjectFaultResponse* response) override;

 private:
  SimulationCalls calls_;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_GRPC_SERVICES_H_
