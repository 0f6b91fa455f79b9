// What is done to a simulated robot, over gRPC.
#include "common/wire/geometry.h"
#include "common/wire/status.h"
#include "nav_agent/service/grpc_services.h"
#include "nav_agent/service/navigation_wire.h"

namespace treeline::agent_service {
namespace {

constexpr double kSize_m = 0.5;

}  // namespace

grpc::Status SimulationGrpcService::Kidnap(grpc::ServerContext* /*context*/,
                                           const v1::KidnapRequest* request,
                                           v1::KidnapResponse* response) {
  absl::StatusOr<geometry::Rigid3> map_from_base;
  switch (request->to_case()) {
    case v1::KidnapRequest::kPlace:
      map_from_base = commands_.KidnapTo(request->place());
      break;
    case v1::KidnapRequest::kMapFromBase:
      map_from_base = commands_.Kidnap(FromProto(request->map_from_base()));
      break;
    default:
      map_from_base = commands_.KidnapAnywhere();
  }
  if (!map_from_base.ok()) return wire::ToGrpc(map_from_base.status());
  *response->mutable_map_from_base() = PlanarToProto(*map_from_base);
  return grpc::Status::OK;
}

grpc::Status SimulationGrpcService::AddObstacle(
    grpc::ServerContext* /*context*/, const v1::AddObstacleRequest* request,
    v1::AddObstacleResponse* response) {
  const absl::StatusOr<std::string> name = commands_.AddObstacle(
      {.x_m = request->x_m(), .y_m = request->y_m(), .level = request->level()},
      request->size_m() == 0 ? kSize_m : request->size_m());
  if (!name.ok()) return wire::ToGrpc(name.status());
  response->set_name(*name);
  return grpc::Status::OK;
}

grpc::Status SimulationGrpcService::RemoveObstacle(
    grpc::ServerContext* /*context*/, const v1::RemoveObstacleRequest* request,
    v1::RemoveObstacleResponse* /*response*/) {
  return wire::ToGrpc(commands_.RemoveObstacle(request->name()));
}

grpc::Status SimulationGrpcService::InjectFault(
    grpc::ServerContext* /*context*/, const v1::InjectFaultRequest* request,
    v1::InjectFaultResponse* /*response*/) {
  if (!(request->duration_s() >= 0 && request->duration_s() <= 1e6)) {
    return wire::ToGrpc(wire::FieldError("duration_s", "must be 0..1000000"));
  }
  return wire::ToGrpc(commands_.InjectFault(
      {.target = request->target(),
       .kind = request->kind(),
       .duration_s = request->duration_s(),
       .amount = request->has_amount() ? request->amount() : 1}));
}

}  // namespace treeline::agent_service
