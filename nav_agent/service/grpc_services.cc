#include "nav_agent/service/grpc_services.h"

#include <utility>

#include "common/wire/status.h"

namespace treeline::agent_service {
namespace {

template <typename Message>
class GrpcSink final : public MessageSink<Message> {
 public:
  GrpcSink(const grpc::ServerContext& context,
           grpc::ServerWriter<Message>& writer)
      : context_(context), writer_(writer) {}

  bool Write(const Message& message) override { return writer_.Write(message); }
  bool IsGone() override { return context_.IsCancelled(); }

 private:
  const grpc::ServerContext& context_;
  grpc::ServerWriter<Message>& writer_;
};

// What a unary call ends with.
template <typename Response>
grpc::Status Answer(absl::StatusOr<Response> answer, Response& response) {
  if (!answer.ok()) return wire::ToGrpc(answer.status());
  response = *std::move(answer);
  return grpc::Status::OK;
}

}  // namespace

grpc::Status NavigationGrpcService::Navigate(
    grpc::ServerContext* context, const v1::NavigateRequest* request,
    grpc::ServerWriter<v1::NavigateResponse>* writer) {
  GrpcSink<v1::NavigateResponse> sink(*context, *writer);
  return wire::ToGrpc(calls_.Navigate(*request, sink));
}

grpc::Status NavigationGrpcService::Cancel(grpc::ServerContext* /*context*/,
                                           const v1::CancelRequest* request,
                                           v1::CancelResponse* response) {
  return Answer(calls_.Cancel(*request), *response);
}

grpc::Status NavigationGrpcService::Pause(grpc::ServerContext* /*context*/,
                                          const v1::PauseRequest* request,
                                          v1::PauseResponse* response) {
  return Answer(calls_.Pause(*request), *response);
}

grpc::Status NavigationGrpcService::Resume(grpc::ServerContext* /*context*/,
                                           const v1::ResumeRequest* request,
                                           v1::ResumeResponse* response) {
  return Answer(calls_.Resume(*request), *response);
}

grpc::Status NavigationGrpcService::Stop(grpc::ServerContext* /*context*/,
                                         const v1::StopRequest* request,
                                         v1::StopResponse* response) {
  return Answer(calls_.Stop(*request), *response);
}

grpc::Status NavigationGrpcService::Release(grpc::ServerContext* /*context*/,
                                            const v1::ReleaseRequest* request,
                                            v1::ReleaseResponse* response) {
  return Answer(calls_.Release(*request), *response);
}

grpc::Status NavigationGrpcService::Drive(grpc::ServerContext* /*context*/,
                                          const v1::DriveRequest* request,
                                          v1::DriveResponse* response) {
  return Answer(calls_.Drive(*request), *response);
}

grpc::Status NavigationGrpcService::StreamState(
    grpc::ServerContext* context, const v1::StreamStateRequest* request,
    grpc::ServerWriter<v1::StreamStateResponse>* writer) {
  GrpcSink<v1::StreamStateResponse> sink(*context, *writer);
  return wire::ToGrpc(calls_.StreamState(*request, sink));
}

grpc::Status NavigationGrpcService::GetInfo(grpc::ServerContext* /*context*/,
                                            const v1::GetInfoRequest* request,
                                            v1::GetInfoResponse* response) {
  return Answer(calls_.GetInfo(*request), *response);
}

grpc::Status NavigationGrpcService::GetMaps(grpc::ServerContext* /*context*/,
                                            const v1::GetMapsRequest* request,
                                            v1::GetMapsResponse* response) {
  return Answer(calls_.GetMaps(*request), *response);
}

grpc::Status NavigationGrpcService::GetZones(grpc::ServerContext* /*context*/,
                                             const v1::GetZonesRequest* request,
                                             v1::GetZonesResponse* response) {
  return Answer(calls_.GetZones(*request), *response);
}

grpc::Status NavigationGrpcService::PutZones(grpc::ServerContext* /*context*/,
                                             const v1::PutZonesRequest* request,
                                             v1::PutZonesResponse* response) {
  return Answer(calls_.PutZones(*request), *response);
}

grpc::Status NavigationGrpcService::RemoveZones(
    grpc::ServerContext* /*context*/, const v1::RemoveZonesRequest* request,
    v1::RemoveZonesResponse* response) {
  return Answer(calls_.RemoveZones(*request), *response);
}

grpc::Status NavigationGrpcService::RunRoute(
    grpc::ServerContext* context, const v1::RunRouteRequest* request,
    grpc::ServerWriter<v1::RunRouteResponse>* writer) {
  GrpcSink<v1::RunRouteResponse> sink(*context, *writer);
  return wire::ToGrpc(calls_.RunRoute(*request, sink));
}

grpc::Status NavigationGrpcService::ResumeRoute(
    grpc::ServerContext* /*context*/, const v1::ResumeRouteRequest* request,
    v1::ResumeRouteResponse* response) {
  return Answer(calls_.ResumeRoute(*request), *response);
}

grpc::Status NavigationGrpcService::CancelRoute(
    grpc::ServerContext* /*context*/, const v1::CancelRouteRequest* request,
    v1::CancelRouteResponse* response) {
  return Answer(calls_.CancelRoute(*request), *response);
}

grpc::Status NavigationGrpcService::GetRoutes(
    grpc::ServerContext* /*context*/, const v1::GetRoutesRequest* request,
    v1::GetRoutesResponse* response) {
  return Answer(calls_.GetRoutes(*request), *response);
}

grpc::Status NavigationGrpcService::PutRoutes(
    grpc::ServerContext* /*context*/, const v1::PutRoutesRequest* request,
    v1::PutRoutesResponse* response) {
  return Answer(calls_.PutRoutes(*request), *response);
}

grpc::Status NavigationGrpcService::RemoveRoutes(
    grpc::ServerContext* /*context*/, const v1::RemoveRoutesRequest* request,
    v1::RemoveRoutesResponse* response) {
  return Answer(calls_.RemoveRoutes(*request), *response);
}

grpc::Status NavigationGrpcService::SetInitialPose(
    grpc::ServerContext* /*context*/, const v1::SetInitialPoseRequest* request,
    v1::SetInitialPoseResponse* response) {
  return Answer(calls_.SetInitialPose(*request), *response);
}

grpc::Status NavigationGrpcService::FindYourself(
    grpc::ServerContext* /*context*/, const v1::FindYourselfRequest* request,
    v1::FindYourselfResponse* response) {
  return Answer(calls_.FindYourself(*request), *response);
}

grpc::Status DockingGrpcService::GetDocks(grpc::ServerContext* /*context*/,
                                          const v1::GetDocksRequest* request,
                                          v1::GetDocksResponse* response) {
  return Answer(calls_.GetDocks(*request), *response);
}

grpc::Status DockingGrpcService::PutDocks(grpc::ServerContext* /*context*/,
                                          const v1::PutDocksRequest* request,
                                          v1::PutDocksResponse* response) {
  return Answer(calls_.PutDocks(*request), *response);
}

grpc::Status DockingGrpcService::RemoveDocks(
    grpc::ServerContext* /*context*/, const v1::RemoveDocksRequest* request,
    v1::RemoveDocksResponse* response) {
  return Answer(calls_.RemoveDocks(*request), *response);
}

grpc::Status DockingGrpcService::Dock(
    grpc::ServerContext* context, const v1::DockRequest* request,
    grpc::ServerWriter<v1::DockResponse>* writer) {
  GrpcSink<v1::DockResponse> sink(*context, *writer);
  return wire::ToGrpc(calls_.Dock(*request, sink));
}

grpc::Status DockingGrpcService::Undock(grpc::ServerContext* /*context*/,
                                        const v1::UndockRequest* request,
                                        v1::UndockResponse* response) {
  return Answer(calls_.Undock(*request), *response);
}

grpc::Status SimulationGrpcService::Kidnap(grpc::ServerContext* /*context*/,
                                           const v1::KidnapRequest* request,
                                           v1::KidnapResponse* response) {
  return Answer(calls_.Kidnap(*request), *response);
}

grpc::Status SimulationGrpcService::AddObstacle(
    grpc::ServerContext* /*context*/, const v1::AddObstacleRequest* request,
    v1::AddObstacleResponse* response) {
  return Answer(calls_.AddObstacle(*request), *response);
}

grpc::Status SimulationGrpcService::RemoveObstacle(
    grpc::ServerContext* /*context*/, const v1::RemoveObstacleRequest* request,
    v1::RemoveObstacleResponse* response) {
  return Answer(calls_.RemoveObstacle(*request), *response);
}

grpc::Status SimulationGrpcService::InjectFault(
    grpc::ServerContext* /*context*/, const v1::InjectFaultRequest* request,
    v1::InjectFaultResponse* response) {
  return Answer(calls_.InjectFault(*request), *response);
}

}  // namespace treeline::agent_service
