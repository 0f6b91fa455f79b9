// A goal from the request to its end.
#ifndef NAV_AGENT_SERVICE_FOLLOW_GOAL_H_
#define NAV_AGENT_SERVICE_FOLLOW_GOAL_H_

#include "absl/status/status.h"
#include "nav_agent/service/agent_commands.h"
#include "nav_agent/service/message_sink.h"
#include "treeline/v1/navigation.pb.h"

namespace treeline::agent_service {

// NavigationService.Navigate: sets the goal and tells `sink` of it until it is
// over. Errors as the proto lists them; CANCELLED: the caller has gone.
absl::Status FollowGoal(AgentCommands& commands,
                        const v1::NavigateRequest& request,
                        MessageSink<v1::NavigateResponse>& sink);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_FOLLOW_GOAL_H_
