#include "nav_agent/service/simulation_calls.h"

#include <string>

#include "common/base/status_macros.h"
#include "common/wire/geometry.h"
#include "nav_agent/service/navigation_wire.h"

namespace treeline::agent_service {
namespace {

constexpr double kSize_m = 0.5;

}  // namespace

absl::StatusOr<v1::KidnapResponse> SimulationCalls::Kidnap(
    const v1::KidnapRequest& request) {
  absl::StatusOr<geometry::Rigid3> map_from_base;
  switch (request.to_case()) {
    case v1::KidnapRequest::kPlace:
      map_from_base = commands_.KidnapTo(request.place());
      break;
    case v1::KidnapRequest::kMapFromBase:
      map_from_base = commands_.Kidnap(FromProto(request.map_from_base()));
      break;
    default:
      map_from_base = commands_.KidnapAnywhere();
  }
  if (!map_from_base.ok()) return map_from_base.status();
  v1::KidnapResponse response;
  *response.mutable_map_from_base() = PlanarToProto(*map_from_base);
  return response;
}

absl::StatusOr<v1::AddObstacleResponse> SimulationCalls::AddObstacle(
    const v1::AddObstacleRequest& request) {
  TL_ASSIGN_OR_RETURN(std::string name,
                      commands_.AddObstacle(
                          {.x_m = request.x_m(),
                           .y_m = request.y_m(),
                           .level = request.level()},
                          request.size_m() == 0 ? kSize_m : request.size_m()));
  v1::AddObstacleResponse response;
  response.set_name(std::move(name));
  return response;
}

absl::StatusOr<v1::RemoveObstacleResponse> SimulationCalls::RemoveObstacle(
    const v1::RemoveObstacleRequest& request) {
  TL_RETURN_IF_ERROR(commands_.RemoveObstacle(request.name()));
  return v1::RemoveObstacleResponse();
}

absl::StatusOr<v1::InjectFaultResponse> SimulationCalls::InjectFault(
    const v1::InjectFaultRequest& request) {
  if (!(request.duration_s() >= 0 && request.duration_s() <= 1e6)) {
    return wire::FieldError("duration_s", "must be 0..1000000");
  }
  TL_RETURN_IF_ERROR(commands_.InjectFault(
      {.target = request.target(),
       .kind = request.kind(),
       .duration_s = request.duration_s(),
       .amount = request.has_amount() ? request.amount() : 1}));
  return v1::InjectFaultResponse();
}

}  // namespace treeline::agent_service
