// The robot's states and events, as they come.
#ifndef NAV_AGENT_SERVICE_WATCH_ROBOT_H_
#define NAV_AGENT_SERVICE_WATCH_ROBOT_H_

#include "absl/status/status.h"
#include "nav_agent/service/agent_hub.h"
#include "nav_agent/service/agent_info.h"
#include "nav_agent/service/message_sink.h"
#include "treeline/v1/navigation.pb.h"

namespace treeline::agent_service {

// NavigationService.StreamState, until nobody hears `sink` (CANCELLED) or the
// hub is closed (UNAVAILABLE). INVALID_ARGUMENT: a field out of its range.
absl::Status WatchRobot(const AgentInfo& info, const AgentHub& hub,
                        const v1::StreamStateRequest& request,
                        MessageSink<v1::StreamStateResponse>& sink);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_WATCH_ROBOT_H_
