// Takes leaves out of trees, and with them the splits that have nothing left to
// tell apart.
#ifndef SERVER_CORE_TRAINING_TREE_PRUNER_H_
#define SERVER_CORE_TRAINING_TREE_PRUNER_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "server/core/training/tree_grower.h"

namespace treeline::training {

// The modes that the leaf at a node is to have; none: it goes.
using ModesOfLeaf = std::function<std::vector<GrownLeaf>(size_t node)>;

// A tree of the splits of `nodes`, a tree in depth-first order, with those
// modes. Where one side of a split goes, the other takes the split's place.
// Empty if all leaves go.
GrownTree TreeWithModes(std::span<const forest::Node> nodes,
                        const ModesOfLeaf& modes_of_leaf);

// The least number of samples of a mode that PruneTree keeps, of a tree whose
// modes have so many: at most min_samples.
uint32_t LeastKept(std::span<const uint32_t> samples_of_mode,
                   uint32_t min_samples);

// `tree` without the modes that hold fewer than `min_samples` samples, as far
// as a quarter of its samples stay: in trees of few samples all leaves are
// small, and the least that leaves so many is taken in place of `min_samples`.
// The same again, with as many samples or fewer, takes little or nothing.
GrownTree PruneTree(const GrownTree& tree, uint32_t min_samples);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_TREE_PRUNER_H_
