// Docks, proto <-> C++. Text that is not UTF-8 gets U+FFFD.
#ifndef NAV_AGENT_SERVICE_DOCKS_WIRE_H_
#define NAV_AGENT_SERVICE_DOCKS_WIRE_H_

#include "nav_agent/service/dock_desk.h"
#include "treeline/v1/docks.pb.h"

namespace treeline::agent_service {

// A staging distance of 0 is what `robot` needs. What else a dock means,
// CheckDock says.
docking::Dock FromProto(const v1::Dock& proto, const core::RobotModel& robot);

v1::Dock ToProto(const docking::Dock& dock);
v1::DockingStatus ToProto(const DockReport& report);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_DOCKS_WIRE_H_
