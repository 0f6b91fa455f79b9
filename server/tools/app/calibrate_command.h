// treeline calibrate: how depth falls on colour, from the frames themselves.
#ifndef SERVER_TOOLS_APP_CALIBRATE_COMMAND_H_
#define SERVER_TOOLS_APP_CALIBRATE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::tools_app {

cli::Command AddCalibrateCommand(CLI::App& app);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_CALIBRATE_COMMAND_H_
