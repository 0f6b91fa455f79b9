// A scene's model made smaller, without the recording it was learnt from.
#ifndef SERVER_TOOLS_SHRINK_H_
#define SERVER_TOOLS_SHRINK_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "server/core/forest/model_file.h"

namespace treeline::tools {

// What became of a model.
struct ShrunkModel {
  std::string file;  // its bytes
  // Leaves with fewer samples were left out; 1: all are there.
  uint32_t min_kept_samples = 1;
  // Components of keyframes' SIFT descriptors are multiples of this; 1: as they
  // were.
  int feature_step = 1;
};

// `model` in at most `max_bytes`, with as little left out as that takes; the
// steps are those of docs/research/model-size.md. Confidence stays as it was
// learnt. A model that is small enough is only packed.
//
// FAILED_PRECONDITION: a part of a scene, or a base without leaves, which
// answer no queries. INVALID_ARGUMENT: even the last step is larger; says how
// large. Forests of methods sift and points-lines are packed, and nothing is
// left out of them.
absl::StatusOr<ShrunkModel> ShrinkModel(const forest::ModelFile& model,
                                        uint64_t max_bytes);

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_SHRINK_H_
