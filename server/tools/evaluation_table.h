// Results as a short table for a terminal.
#ifndef SERVER_TOOLS_EVALUATION_TABLE_H_
#define SERVER_TOOLS_EVALUATION_TABLE_H_

#include <string>
#include <vector>

#include "server/core/forest/model_info.h"
#include "server/tools/evaluation.h"

namespace treeline {

// Headline figures, one a line, and the first few errors with their files.
std::string EvaluationTable(const std::vector<FrameResult>& results,
                            const ModelInfo& model);

}  // namespace treeline

#endif  // SERVER_TOOLS_EVALUATION_TABLE_H_
