// ModelInfo <-> the JSON that a model file carries.
#ifndef SERVER_CORE_FOREST_MODEL_INFO_JSON_H_
#define SERVER_CORE_FOREST_MODEL_INFO_JSON_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/core/forest/model_info.h"

namespace treeline::forest {

// What the trainer states: method, provenance, options, calibration, training
// summary. Sizes and bounds come from the forest itself.
std::string ModelInfoToJson(const ModelInfo& info);
// DATA_LOSS for anything malformed.
absl::StatusOr<ModelInfo> ModelInfoFromJson(absl::string_view json);

}  // namespace treeline::forest

#endif  // SERVER_CORE_FOREST_MODEL_INFO_JSON_H_
