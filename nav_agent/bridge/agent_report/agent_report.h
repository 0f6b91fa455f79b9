// The agent's state as messages that Nav2 and RViz know.
#ifndef NAV_AGENT_BRIDGE_AGENT_REPORT_AGENT_REPORT_H_
#define NAV_AGENT_BRIDGE_AGENT_REPORT_AGENT_REPORT_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry/rigid3.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"
#include "nav_agent/behavior/navigator_snapshot.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/service/agent_hub.h"

namespace treeline::agent_report {

// The base in the map: on the ground of its level, tilted as it is.
geometry::Rigid3 MapFromBase(const localization::TrackedPose& pose);

// As AMCL tells it. The variance of what a robot on the ground cannot be unsure
// of is 0.
messages::PoseWithCovarianceStamped PlaceOf(
    const localization::TrackedPose& pose, const messages::Header& header);

// Each pose of the path has the header, too.
messages::Path PathOf(const std::vector<core::LevelPose>& path,
                      const messages::Header& header);

// What the topics themselves tell.
struct TopicFacts {
  int64_t delivered = 0;
  int64_t refused = 0;
  int64_t clock_jumps = 0;
  int64_t odometry_leaps = 0;
  bool is_clock_running = true;
};

// Statuses "treeline: navigation", "treeline: localization", "treeline: goal"
// once there was one, "treeline: topics" if it lives by topics, and one for
// each device.
messages::DiagnosticArray ReportOf(const agent_service::AgentState& state,
                                   const std::optional<TopicFacts>& topics,
                                   const messages::Time& stamp);

}  // namespace treeline::agent_report

#endif  // NAV_AGENT_BRIDGE_AGENT_REPORT_AGENT_REPORT_H_
