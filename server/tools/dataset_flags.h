// The options that name a recording, the same in every subcommand.
#ifndef SERVER_TOOLS_DATASET_FLAGS_H_
#define SERVER_TOOLS_DATASET_FLAGS_H_

#include "common/dataset/dataset.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace treeline::tools {

// Adds --dataset (required), --frames, --poses, --color-camera,
// --depth-camera, --depth-unit and --max-time-difference to `app`. `options`
// must live as long as `app`.
// Returns --dataset, which is required unless told otherwise.
CLI::Option* AddDatasetFlags(CLI::App& app, dataset::DatasetOptions& options);

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_DATASET_FLAGS_H_
