// Grows one tree on SIFT samples.
#ifndef SERVER_CORE_TRAINING_SIFT_TREE_GROWER_H_
#define SERVER_CORE_TRAINING_SIFT_TREE_GROWER_H_

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "server/core/forest/forest.h"
#include "server/core/training/sift_trainer.h"
#include "server/core/training/split_objective.h"

namespace treeline::training {

// Labelled features; slot i of both arrays belongs to sample i.
struct SiftSamples {
  std::vector<features::SiftDescriptor> descriptor;
  std::vector<int32_t> point;
};

// A tree in depth-first order, whose leaves number its modes from 0.
struct GrownSiftTree {
  struct Mode {
    int32_t point = 0;
    uint32_t count = 0;
    features::SiftDescriptor descriptor;  // mean of the samples'
  };
  std::vector<forest::Node> nodes;
  std::vector<Mode> modes;
};

// Grows a tree on the samples `chosen` (indices into `samples`). position[p]
// is that of point p. Random draws depend on (options.seed, tree, a node's
// place in the tree) alone. Returns a useless tree once `stop` is requested.
GrownSiftTree GrowSiftTree(const SiftSamples& samples,
                           std::span<const Label> position,
                           std::vector<uint32_t> chosen,
                           const SiftTrainingOptions& options, int tree,
                           const std::stop_token& stop);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_SIFT_TREE_GROWER_H_
