// NavigationService, DockingService and SimulationService over Connect.
#ifndef NAV_AGENT_SERVICE_CONNECT_SERVICES_H_
#define NAV_AGENT_SERVICE_CONNECT_SERVICES_H_

#include "common/connect_rpc/connect_router.h"
#include "nav_agent/service/docking_calls.h"
#include "nav_agent/service/navigation_calls.h"
#include "nav_agent/service/simulation_calls.h"

namespace treeline::agent_service {

// Each: `calls` must outlive `router`.
void AddNavigationCalls(NavigationCalls& calls,
                        connect_rpc::ConnectRouter& router);
void AddDockingCalls(DockingCalls& calls, connect_rpc::ConnectRouter& router);
void AddSimulationCalls(SimulationCalls& calls,
                        connect_rpc::ConnectRouter& router);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_CONNECT_SERVICES_H_
