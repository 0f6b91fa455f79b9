// The robot's state and wishes, proto <-> C++. Text that is not UTF-8, which a
// message must be, gets U+FFFD.
#ifndef NAV_AGENT_SERVICE_NAVIGATION_WIRE_H_
#define NAV_AGENT_SERVICE_NAVIGATION_WIRE_H_

#include <vector>

#include "absl/status/statusor.h"
#include "common/wire/geometry.h"
#include "google/protobuf/repeated_ptr_field.h"
#include "nav_agent/service/agent_commands.h"
#include "nav_agent/service/agent_hub.h"
#include "nav_agent/service/agent_info.h"
#include "treeline/v1/navigation.pb.h"

namespace treeline::agent_service {

using wire::ToProto;

RequestedPose FromProto(const v1::LevelPose& proto);
std::vector<RequestedPose> FromProto(
    const google::protobuf::RepeatedPtrField<v1::LevelPose>& proto);
// `proto` must be one of those that ToProto makes.
behavior::NavigatorMode FromProto(v1::NavigatorMode proto);
core::NavigationCause FromProto(v1::NavigationCause proto);
behavior::GoalState FromProto(v1::GoalState proto);

v1::LevelPose ToProto(const core::LevelPose& pose);
// As it is seen from above; without a level.
v1::LevelPose PlanarToProto(const geometry::Rigid3& map_from_base);
v1::NavigatorMode ToProto(behavior::NavigatorMode mode);
v1::NavigationCause ToProto(core::NavigationCause cause);
v1::GoalState ToProto(behavior::GoalState state);
v1::GoalStatus ToProto(const behavior::GoalStatus& goal);
v1::RobotEvent ToProto(const AgentHub::Event& event);
v1::NavigateResponse FeedbackToProto(const AgentState& state);
// `state` must have a route.
v1::RunRouteResponse RouteFeedbackToProto(const AgentState& state);
// Without its picture.
v1::MapLevel ToProto(const traversability::TraversableLevel& level, int index);
v1::GetInfoResponse InfoToProto(const AgentInfo& info);
v1::RobotState StateToProto(const AgentInfo& info, const AgentState& state);
v1::RobotScene SceneToProto(const AgentState& state);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_NAVIGATION_WIRE_H_
