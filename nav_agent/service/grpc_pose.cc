// Where the robot is, over gRPC.
#include "common/wire/geometry.h"
#include "common/wire/status.h"
#include "nav_agent/service/grpc_services.h"
#include "nav_agent/service/navigation_wire.h"

namespace treeline::agent_service {
namespace {

constexpr double kStd_m = 0.25;
constexpr double kStd_rad = 0.2;

}  // namespace

grpc::Status NavigationGrpcService::SetInitialPose(
    grpc::ServerContext* /*context*/, const v1::SetInitialPoseRequest* request,
    v1::SetInitialPoseResponse* /*response*/) {
  if (!request->has_map_from_base()) {
    return wire::ToGrpc(wire::FieldError("map_from_base", "is missing"));
  }
  return wire::ToGrpc(commands_.SetPose(
      FromProto(request->map_from_base()),
      request->std_m() == 0 ? kStd_m : request->std_m(),
      request->std_rad() == 0 ? kStd_rad : request->std_rad()));
}

grpc::Status NavigationGrpcService::FindYourself(
    grpc::ServerContext* /*context*/,
    const v1::FindYourselfRequest* /*request*/,
    v1::FindYourselfResponse* /*response*/) {
  return wire::ToGrpc(commands_.FindYourself());
}

}  // namespace treeline::agent_service
