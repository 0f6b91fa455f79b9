// treeline import: recordings of what people captured with phones.
#ifndef SERVER_TOOLS_APP_IMPORT_COMMAND_H_
#define SERVER_TOOLS_APP_IMPORT_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::tools_app {

cli::Command AddImportCommand(CLI::App& app);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_IMPORT_COMMAND_H_
