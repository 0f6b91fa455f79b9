// The robot as JSON, for the operator's page. docs/agent.md has the fields.
#ifndef NAV_AGENT_SERVICE_API_JSON_H_
#define NAV_AGENT_SERVICE_API_JSON_H_

#include <string>

#include "absl/status/status.h"
#include "nav_agent/service/agent_hub.h"
#include "nav_agent/service/agent_info.h"

namespace treeline::agent_service {

// Numbers are rounded to what a picture needs (0.1 mm, 0.1 mrad); what is not
// finite becomes null, and text that is not UTF-8 gets U+FFFD.

// /api/info.
std::string InfoJson(const AgentInfo& info);
// /api/state.
std::string StateJson(const AgentInfo& info, const AgentState& state);
// /api/scene; at most 500 particles.
std::string SceneJson(const AgentState& state);
// Of the stream.
std::string EventJson(const AgentHub::Event& event);
// {"error":{"code","message"}}; code: "invalid_argument" and so on. `status` is
// not OK.
std::string ErrorJson(const absl::Status& status);
// {"error":{"code","message"}} of HTTP itself.
std::string ErrorJson(const std::string& code, const std::string& message);

// "invalid_argument" and so on.
std::string CodeText(absl::StatusCode code);

// "accepted", "active", "succeeded", "failed", "cancelled".
const char* GoalStateName(behavior::GoalState state);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_API_JSON_H_
