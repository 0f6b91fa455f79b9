// Grown trees as the model file holds them.
#ifndef SERVER_CORE_TRAINING_QUANTIZE_FOREST_H_
#define SERVER_CORE_TRAINING_QUANTIZE_FOREST_H_

#include <vector>

#include "server/core/forest/forest.h"
#include "server/core/training/tree_grower.h"

namespace treeline::training {

// Appends all trees to one forest, positions relative to their bounds.
forest::Forest QuantizeForest(std::vector<GrownTree> trees);

// The inverse, as far as that goes: tree t of `forest`, its leaves' modes as
// GrownLeaf.
GrownTree GrownTreeOf(const forest::ForestView& forest, int t);

// The splits of a forest alone, all leaves one and the same: what a base for
// Refill::kAdapt needs, in a fraction of the bytes.
forest::Forest SplitsOf(const forest::ForestView& forest);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_QUANTIZE_FOREST_H_
