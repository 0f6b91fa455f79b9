// What does not change while an agent runs, and what stands around its hub.
#ifndef NAV_AGENT_SERVICE_AGENT_INFO_H_
#define NAV_AGENT_SERVICE_AGENT_INFO_H_

#include <memory>
#include <string>
#include <vector>

#include "nav_agent/behavior/navigator.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::agent_service {

struct AgentInfo {
  std::string version;
  core::RobotModel robot;
  std::string map_name;
  // Never null.
  std::shared_ptr<const behavior::NavigatorMap> map;
  // In simulation: the world, and its places.
  bool is_simulated = false;
  std::string world;
  std::vector<std::string> places;
  // HOST:PORT of the relocalization server; empty: none.
  std::string server;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_AGENT_INFO_H_
