// What a navigator is made with: of the agent's settings and its robot.
#ifndef NAV_AGENT_APP_RUN_NAVIGATOR_SETUP_H_
#define NAV_AGENT_APP_RUN_NAVIGATOR_SETUP_H_

#include "nav_agent/app/run/agent_config.h"
#include "nav_agent/app/run/agent_robot.h"
#include "nav_agent/behavior/navigator_options.h"
#include "nav_agent/mapless/mapless_navigator.h"

namespace treeline::run_app {

inline constexpr double kControlHz = 40;

// On a map. The robot's lasers have spoken: how long a scan takes says for how
// long one may be silent.
behavior::NavigatorOptions NavigatorOptionsOf(const AgentConfig& config,
                                              AgentRobot& robot);
// By sight; without what is known of the place.
mapless::MaplessOptions SightOptionsOf(const AgentConfig& config);

}  // namespace treeline::run_app

#endif  // NAV_AGENT_APP_RUN_NAVIGATOR_SETUP_H_
