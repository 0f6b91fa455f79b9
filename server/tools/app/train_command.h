// treeline train: recorded frames in, one model file out. treeline merge: the
// same of trees that other machines have grown.
#ifndef SERVER_TOOLS_APP_TRAIN_COMMAND_H_
#define SERVER_TOOLS_APP_TRAIN_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::tools_app {

cli::Command AddTrainCommand(CLI::App& app);
cli::Command AddMergeCommand(CLI::App& app);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_TRAIN_COMMAND_H_
