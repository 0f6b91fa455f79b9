// Results as JSON: the contract others script against (docs/evaluation.md).
#ifndef SERVER_TOOLS_EVALUATION_JSON_H_
#define SERVER_TOOLS_EVALUATION_JSON_H_

#include <cstdint>
#include <string>
#include <vector>

#include "server/core/forest/model_info.h"
#include "server/tools/evaluation.h"

namespace treeline {

// What was evaluated, on what, and with which command.
struct EvaluationRun {
  std::string model_path;  // empty: a baseline without a file
  std::string dataset_uri;
  std::string frame_list;  // empty: all frames
  std::string pose_file;   // empty: the sequence's own poses
  uint64_t seed = 0;
  int threads = 1;
  std::string command;
  std::string cpu;
  std::string software_version;
  std::string started_utc;
  uint64_t peak_memory_bytes = 0;
};

// One JSON object with a trailing newline. What is undefined, or not finite,
// is null. Angles are in degrees, lengths in metres, fractions in [0, 1].
std::string EvaluationJson(const std::vector<FrameResult>& results,
                           const EvaluationRun& run, const ModelInfo& model);

// What a model file says about itself, as one JSON object with a trailing
// newline.
std::string ModelInfoJson(const ModelInfo& model);

}  // namespace treeline

#endif  // SERVER_TOOLS_EVALUATION_JSON_H_
