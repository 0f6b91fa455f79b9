// One tree of a scene, grown apart from the others, as a file: so that a scene
// is learnt by as many machines as it has trees.
#ifndef SERVER_CORE_TRAINING_TREE_PART_H_
#define SERVER_CORE_TRAINING_TREE_PART_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"
#include "server/core/forest/model_info.h"
#include "server/core/training/tree_grower.h"

namespace treeline::training {

// What one machine grew. A scene is learnt in one round or two (first without
// the frames that are held out for its confidence, then from all), and a method
// has one forest or two: `trees` holds this part's tree of each forest of each
// round, in this order.
struct TreePart {
  // info.part is there; info.training_samples counts the last round.
  forest::ModelInfo info;
  std::vector<GrownTree> trees;
};

// Writes a part as a model file (docs/reference/model-format.md), atomically.
// Nothing is lost: what is read back makes the same forest, to the bit.
absl::Status WriteTreePart(const std::string& path, const TreePart& part);

// Errors as ModelFile::Open; FAILED_PRECONDITION for a model that is no part;
// DATA_LOSS for a part that contradicts itself. Safe on hostile files.
absl::StatusOr<TreePart> ReadTreePart(const std::string& path);

// The parts, by tree: all trees of one scene, each once. INVALID_ARGUMENT,
// naming files and what differs, where a tree is missing or there twice, or
// where parts were grown from other frames, with another calibration, other
// options or by another version.
absl::StatusOr<std::vector<TreePart>> ReadTreeParts(
    const std::vector<std::string>& paths);

// Names and poses of the frames, as TreePartInfo::frames_checksum has them.
// Where the recording lies does not matter, nor do digits of a pose beyond the
// sixth decimal.
std::string FramesChecksum(const dataset::Dataset& dataset);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_TREE_PART_H_
