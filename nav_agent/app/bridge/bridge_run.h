// treeline-agent bridge: a place finder among the nodes of a robot.
#ifndef NAV_AGENT_APP_BRIDGE_BRIDGE_RUN_H_
#define NAV_AGENT_APP_BRIDGE_BRIDGE_RUN_H_

#include <functional>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "common/log/program_log.h"
#include "nav_agent/app/bridge/bridge_config.h"
#include "nav_agent/core/relocalization.h"

namespace treeline::bridge_app {

// Runs until `stop` is requested or the duration is over. sensors: of the
// robot's file, if the settings name one. announce: called with lines for
// scripts ("bridge in domain 0"). Errors: INVALID_ARGUMENT for settings;
// UNAVAILABLE for a network that is not there. That nobody publishes, or the
// server is away, is no error.
absl::Status RunBridge(
    const BridgeConfig& config, const SensorsOfFile& sensors,
    core::RelocalizationPort& server, logging::ProgramLog& log,
    const std::function<void(const std::string& line)>& announce,
    const std::stop_token& stop);

}  // namespace treeline::bridge_app

#endif  // NAV_AGENT_APP_BRIDGE_BRIDGE_RUN_H_
