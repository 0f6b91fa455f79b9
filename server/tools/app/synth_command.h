// treeline synth: recordings of worlds that exist only here.
#ifndef SERVER_TOOLS_APP_SYNTH_COMMAND_H_
#define SERVER_TOOLS_APP_SYNTH_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::tools_app {

cli::Command AddSynthCommand(CLI::App& app);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_SYNTH_COMMAND_H_
