// Grown trees as the model file holds them.
#ifndef SERVER_CORE_TRAINING_QUANTIZE_FOREST_H_
#define SERVER_CORE_TRAINING_QUANTIZE_FOREST_H_

#include <vector>

#include "server/core/forest/forest.h"
#include "server/core/training/tree_grower.h"

namespace treeline {

// Appends all trees to one forest, positions relative to their bounds.
Forest QuantizeForest(std::vector<GrownTree> trees);

// The inverse, as far as that goes: tree t of `forest`, its leaves' modes as
// GrownLeaf.
GrownTree GrownTreeOf(const ForestView& forest, int t);

}  // namespace treeline

#endif  // SERVER_CORE_TRAINING_QUANTIZE_FOREST_H_
