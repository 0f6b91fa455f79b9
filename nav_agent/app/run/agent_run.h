// treeline-agent run: everything that drives, wired.
#ifndef NAV_AGENT_APP_RUN_AGENT_RUN_H_
#define NAV_AGENT_APP_RUN_AGENT_RUN_H_

#include <functional>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "common/log/program_log.h"
#include "nav_agent/app/run/agent_config.h"

namespace treeline::run_app {

// Drives until `stop` is requested or the duration is over; then the robot
// stands. announce: called with lines for scripts ("grpc on 127.0.0.1:50061",
// "page on http://127.0.0.1:8081/", "driving"). Errors: INVALID_ARGUMENT for
// settings; those of maps, worlds, devices and addresses. That a server or a
// page is not there is no error.
absl::Status RunAgent(
    const AgentConfig& config, logging::ProgramLog& log,
    const std::function<void(const std::string& line)>& announce,
    const std::stop_token& stop);

}  // namespace treeline::run_app

#endif  // NAV_AGENT_APP_RUN_AGENT_RUN_H_
