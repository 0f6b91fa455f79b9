#include "nav_agent/service/follow_route.h"

#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/wire/geometry.h"
#include "nav_agent/service/navigation_wire.h"
#include "nav_agent/service/routes_wire.h"
#include "nav_agent/service/tell_until_over.h"

namespace treeline::agent_service {
namespace {

absl::StatusOr<routes::Route> WantedRoute(const AgentCommands& commands,
                                          const v1::RunRouteRequest& request) {
  switch (request.what_case()) {
    case v1::RunRouteRequest::kKept:
      return commands.routes().book().Find(request.kept());
    case v1::RunRouteRequest::kRoute:
      return FromProto(request.route());
    case v1::RunRouteRequest::WHAT_NOT_SET:
      break;
  }
  return wire::FieldError("what", "is missing: name a route, or send one");
}

// nullopt: the state is older than the route.
std::optional<v1::RunRouteResponse> FeedbackOf(const AgentState& state,
                                               uint64_t route_id) {
  if (!state.route.has_value() || state.route->id < route_id) {
    return std::nullopt;
  }
  v1::RunRouteResponse message = RouteFeedbackToProto(state);
  if (state.route->id == route_id) {
    message.set_is_final(routes::IsOver(state.route->state));
    return message;
  }
  v1::RouteStatus& status = *message.mutable_route();
  status.Clear();
  status.set_id(route_id);
  status.set_state(v1::ROUTE_STATE_CANCELLED);
  status.set_why(absl::StrCat("route ", state.route->id, " took its place"));
  message.set_is_final(true);
  return message;
}

}  // namespace

absl::Status FollowRoute(AgentCommands& commands,
                         const v1::RunRouteRequest& request,
                         MessageSink<v1::RunRouteResponse>& sink) {
  TL_ASSIGN_OR_RETURN(routes::Route route, WantedRoute(commands, request));
  if (request.first_waypoint() < 0) {
    return wire::FieldError("first_waypoint", "is below 0");
  }
  TL_ASSIGN_OR_RETURN(
      const uint64_t id,
      commands.RunRoute(std::move(route),
                        static_cast<size_t>(request.first_waypoint())));
  const absl::Status told = TellUntilOver<v1::RunRouteResponse>(
      commands.hub(),
      [id](const AgentState& state) { return FeedbackOf(state, id); }, sink);
  if (absl::IsCancelled(told) && !request.keep_when_call_ends()) {
    // NOT_FOUND where it is over by now, or another took its place.
    commands.CancelRoute(id).IgnoreError();
  }
  return told;
}

}  // namespace treeline::agent_service
