// What a place finder has to say of itself and of the robot, as diagnostics.
#ifndef NAV_AGENT_BRIDGE_PLACE_FINDER_PLACE_REPORT_H_
#define NAV_AGENT_BRIDGE_PLACE_FINDER_PLACE_REPORT_H_

#include "common/ros2/messages/common_messages.h"
#include "nav_agent/bridge/place_finder/place_finder.h"

namespace treeline::place_finder {

// Level, message and values: OK, WARN (people or changes hide the map), ERROR
// (lost).
void TellVerdict(const localization::LostVerdict& verdict,
                 messages::DiagnosticStatus& status);

// Two statuses: "treeline: localization" (as TellVerdict; STALE: nothing to
// judge by) and "treeline: relocalization" (ERROR: the server cannot be asked,
// or knows another place).
messages::DiagnosticArray ReportOf(const PlaceFinder::State& state,
                                   const messages::Time& stamp);

}  // namespace treeline::place_finder

#endif  // NAV_AGENT_BRIDGE_PLACE_FINDER_PLACE_REPORT_H_
