// treeline-agent calibrate: wheels and laser from a recorded drive.
#ifndef NAV_AGENT_APP_CALIBRATE_CALIBRATE_COMMAND_H_
#define NAV_AGENT_APP_CALIBRATE_CALIBRATE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::calibrate_app {

cli::Command AddCalibrateCommand(CLI::App& app);

}  // namespace treeline::calibrate_app

#endif  // NAV_AGENT_APP_CALIBRATE_CALIBRATE_COMMAND_H_
