#include "nav_agent/service/navigation_calls.h"

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/wire/geometry.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/service/follow_goal.h"
#include "nav_agent/service/follow_route.h"
#include "nav_agent/service/map_pictures.h"
#include "nav_agent/service/navigation_wire.h"
#include "nav_agent/service/routes_wire.h"
#include "nav_agent/service/stream_slot.h"
#include "nav_agent/service/watch_robot.h"
#include "nav_agent/service/zones_wire.h"

namespace treeline::agent_service {
namespace {

// How far off a person is who tells the robot where it is, if they do not say.
constexpr double kStd_m = 0.25;
constexpr double kStd_rad = 0.2;

absl::Status TooManyStreams() {
  return absl::ResourceExhaustedError("too many streams are open");
}

}  // namespace

absl::Status NavigationCalls::Navigate(
    const v1::NavigateRequest& request,
    MessageSink<v1::NavigateResponse>& sink) {
  const StreamSlot slot(streams_, max_streams_);
  if (!slot.is_taken()) return TooManyStreams();
  return FollowGoal(commands_, request, sink);
}

absl::Status NavigationCalls::StreamState(
    const v1::StreamStateRequest& request,
    MessageSink<v1::StreamStateResponse>& sink) {
  const StreamSlot slot(streams_, max_streams_);
  if (!slot.is_taken()) return TooManyStreams();
  return WatchRobot(commands_.info(), commands_.hub(), request, sink);
}

absl::StatusOr<v1::CancelResponse> NavigationCalls::Cancel(
    const v1::CancelRequest& request) {
  TL_RETURN_IF_ERROR(commands_.Cancel(request.goal_id()));
  return v1::CancelResponse();
}

absl::StatusOr<v1::PauseResponse> NavigationCalls::Pause(
    const v1::PauseRequest& /*request*/) {
  TL_RETURN_IF_ERROR(commands_.Pause());
  return v1::PauseResponse();
}

absl::StatusOr<v1::ResumeResponse> NavigationCalls::Resume(
    const v1::ResumeRequest& /*request*/) {
  TL_RETURN_IF_ERROR(commands_.Resume());
  return v1::ResumeResponse();
}

absl::StatusOr<v1::StopResponse> NavigationCalls::Stop(
    const v1::StopRequest& request) {
  TL_ASSIGN_OR_RETURN(const StopKeeping kept, commands_.Stop(request.why()));
  v1::StopResponse response;
  response.set_survives_restart(kept.status.ok());
  response.set_warning(std::string(kept.status.message()));
  return response;
}

absl::StatusOr<v1::ReleaseResponse> NavigationCalls::Release(
    const v1::ReleaseRequest& /*request*/) {
  TL_ASSIGN_OR_RETURN(const StopKeeping kept, commands_.Release());
  v1::ReleaseResponse response;
  response.set_warning(std::string(kept.status.message()));
  return response;
}

absl::StatusOr<v1::DriveResponse> NavigationCalls::Drive(
    const v1::DriveRequest& request) {
  TL_RETURN_IF_ERROR(
      commands_.Drive({.forward_mps = request.forward_mps(),
                       .yaw_rate_radps = request.yaw_rate_radps()},
                      request.driver(), request.sequence()));
  v1::DriveResponse response;
  response.set_lease_s(behavior::kManualLease_s);
  return response;
}

absl::StatusOr<v1::GetInfoResponse> NavigationCalls::GetInfo(
    const v1::GetInfoRequest& /*request*/) const {
  return InfoToProto(commands_.info());
}

absl::StatusOr<v1::GetMapsResponse> NavigationCalls::GetMaps(
    const v1::GetMapsRequest& request) const {
  const AgentInfo& info = commands_.info();
  const auto& levels = info.map->levels.levels;
  v1::GetMapsResponse response;
  response.set_name(info.map_name);
  for (size_t i = 0; i < levels.size(); ++i) {
    *response.add_levels() = ToProto(levels[i], static_cast<int>(i));
  }
  for (const int index : request.picture_levels()) {
    if (index < 0 || static_cast<size_t>(index) >= levels.size()) {
      return wire::FieldError(
          "picture_levels",
          absl::StrCat("has ", index, "; the map has 0..", levels.size() - 1));
    }
    v1::MapLevel& level = *response.mutable_levels(index);
    if (!level.png().empty()) continue;
    TL_ASSIGN_OR_RETURN(*level.mutable_png(),
                        LevelPng(levels[static_cast<size_t>(index)].grid));
  }
  return response;
}

absl::StatusOr<v1::GetZonesResponse> NavigationCalls::GetZones(
    const v1::GetZonesRequest& /*request*/) const {
  const ZoneBook& book = commands_.zones();
  const ZoneBookContents contents = book.contents();
  v1::GetZonesResponse response;
  response.set_revision(contents.revision);
  for (const zones::Zone& zone : contents.zones) {
    *response.add_zones() = ToProto(zone);
  }
  for (const zones::ZoneMask& mask : book.masks()) {
    *response.add_masks() = ToProto(mask, book.RunsOf(mask));
  }
  response.set_survives_restart(book.keeping().ok());
  response.set_warning(std::string(book.keeping().message()));
  return response;
}

absl::StatusOr<v1::PutZonesResponse> NavigationCalls::PutZones(
    const v1::PutZonesRequest& request) {
  std::vector<zones::Zone> zones;
  for (const v1::Zone& proto : request.zones()) {
    TL_ASSIGN_OR_RETURN(zones::Zone zone, FromProto(proto));
    zones.push_back(std::move(zone));
  }
  if (zones.empty()) return wire::FieldError("zones", "has none");
  TL_ASSIGN_OR_RETURN(const ZoneBookContents contents,
                      commands_.PutZones(zones));
  const absl::Status keeping = commands_.zones().keeping();
  v1::PutZonesResponse response;
  response.set_revision(contents.revision);
  response.set_survives_restart(keeping.ok());
  response.set_warning(std::string(keeping.message()));
  return response;
}

absl::StatusOr<v1::RemoveZonesResponse> NavigationCalls::RemoveZones(
    const v1::RemoveZonesRequest& request) {
  TL_ASSIGN_OR_RETURN(
      const ZoneBookContents contents,
      commands_.RemoveZones({request.names().begin(), request.names().end()}));
  v1::RemoveZonesResponse response;
  response.set_revision(contents.revision);
  return response;
}

absl::Status NavigationCalls::RunRoute(
    const v1::RunRouteRequest& request,
    MessageSink<v1::RunRouteResponse>& sink) {
  const StreamSlot slot(streams_, max_streams_);
  if (!slot.is_taken()) return TooManyStreams();
  return FollowRoute(commands_, request, sink);
}

absl::StatusOr<v1::ResumeRouteResponse> NavigationCalls::ResumeRoute(
    const v1::ResumeRouteRequest& /*request*/) {
  TL_RETURN_IF_ERROR(commands_.ResumeRoute());
  return v1::ResumeRouteResponse();
}

absl::StatusOr<v1::CancelRouteResponse> NavigationCalls::CancelRoute(
    const v1::CancelRouteRequest& /*request*/) {
  TL_RETURN_IF_ERROR(commands_.CancelRoute());
  return v1::CancelRouteResponse();
}

uint64_t NavigationCalls::RoutesRevision() const {
  const std::shared_ptr<const AgentState> state = commands_.hub().Latest();
  const bool has_route = state != nullptr && state->route.has_value();
  return commands_.routes().book().revision() +
         (has_route ? state->route->id : 0);
}

absl::StatusOr<v1::GetRoutesResponse> NavigationCalls::GetRoutes(
    const v1::GetRoutesRequest& /*request*/) const {
  const RouteBook& book = commands_.routes().book();
  const KeptContents<routes::Route> contents = book.contents();
  const std::shared_ptr<const AgentState> state = commands_.hub().Latest();
  v1::GetRoutesResponse response;
  response.set_revision(RoutesRevision());
  for (const routes::Route& route : contents.things) {
    *response.add_routes() = ToProto(route);
  }
  if (state != nullptr && state->route.has_value() &&
      !routes::IsOver(state->route->state)) {
    *response.mutable_current() = ToProto(*state->route->progress.route);
  }
  response.set_survives_restart(book.keeping().ok());
  response.set_warning(std::string(book.keeping().message()));
  return response;
}

absl::StatusOr<v1::PutRoutesResponse> NavigationCalls::PutRoutes(
    const v1::PutRoutesRequest& request) {
  std::vector<routes::Route> routes;
  for (const v1::Route& proto : request.routes()) {
    TL_ASSIGN_OR_RETURN(routes::Route route, FromProto(proto));
    routes.push_back(std::move(route));
  }
  if (routes.empty()) return wire::FieldError("routes", "has none");
  RouteBook& book = commands_.routes().book();
  TL_RETURN_IF_ERROR(book.Put(routes).status());
  v1::PutRoutesResponse response;
  response.set_revision(RoutesRevision());
  response.set_survives_restart(book.keeping().ok());
  response.set_warning(std::string(book.keeping().message()));
  return response;
}

absl::StatusOr<v1::RemoveRoutesResponse> NavigationCalls::RemoveRoutes(
    const v1::RemoveRoutesRequest& request) {
  TL_RETURN_IF_ERROR(
      commands_.routes()
          .book()
          .Remove({request.names().begin(), request.names().end()})
          .status());
  v1::RemoveRoutesResponse response;
  response.set_revision(RoutesRevision());
  return response;
}

absl::StatusOr<v1::SetInitialPoseResponse> NavigationCalls::SetInitialPose(
    const v1::SetInitialPoseRequest& request) {
  if (!request.has_map_from_base()) {
    return wire::FieldError("map_from_base", "is missing");
  }
  TL_RETURN_IF_ERROR(
      commands_.SetPose(FromProto(request.map_from_base()),
                        request.std_m() == 0 ? kStd_m : request.std_m(),
                        request.std_rad() == 0 ? kStd_rad : request.std_rad()));
  return v1::SetInitialPoseResponse();
}

absl::StatusOr<v1::FindYourselfResponse> NavigationCalls::FindYourself(
    const v1::FindYourselfRequest& /*request*/) {
  TL_RETURN_IF_ERROR(commands_.FindYourself());
  return v1::FindYourselfResponse();
}

}  // namespace treeline::agent_service
