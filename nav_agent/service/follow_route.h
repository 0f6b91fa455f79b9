// A route from the request to its end.
#ifndef NAV_AGENT_SERVICE_FOLLOW_ROUTE_H_
#define NAV_AGENT_SERVICE_FOLLOW_ROUTE_H_

#include "absl/status/status.h"
#include "nav_agent/service/agent_commands.h"
#include "nav_agent/service/message_sink.h"
#include "treeline/v1/navigation.pb.h"

namespace treeline::agent_service {

// NavigationService.RunRoute: begins the route and tells `sink` of it until it
// is over. Errors as the proto lists them; CANCELLED: the caller has gone.
absl::Status FollowRoute(AgentCommands& commands,
                         const v1::RunRouteRequest& request,
                         MessageSink<v1::RunRouteResponse>& sink);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_FOLLOW_ROUTE_H_
