// The robot as JSON, for scripts. docs/reference/agent.md has the fields.
#ifndef NAV_AGENT_SERVICE_API_JSON_H_
#define NAV_AGENT_SERVICE_API_JSON_H_

#include <string>

#include "absl/status/status.h"
#include "nav_agent/behavior/navigator.h"
#include "treeline/v1/navigation.pb.h"

namespace treeline::agent_service {

// Numbers are rounded to what a picture needs (0.1 mm, 0.1 mrad); what is not
// finite becomes null, and text that is not UTF-8 gets U+FFFD.

// All are other words for the messages of navigation.proto, which say more.

// /api/info.
std::string InfoJson(const v1::GetInfoResponse& info);
// /api/state. Enumerators must be known ones.
std::string StateJson(const v1::RobotState& state);
// /api/scene.
std::string SceneJson(const v1::RobotScene& scene);
// Of the stream.
std::string EventJson(const v1::RobotEvent& event);
// {"ok":true}, and {"warning"} if it is not OK: of what was done.
std::string WarnedJson(const absl::Status& warning);
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
