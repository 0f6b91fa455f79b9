#include "server/core/training/tree_pruner.h"

namespace treeline::training {
namespace {

constexpr double kMinKeptShare = 0.25;

}  // namespace

uint32_t LeastKept(std::span<const uint32_t> samples_of_mode,
                   uint32_t min_samples) {
  double all = 0;
  for (const uint32_t count : samples_of_mode) all += count;
  const auto share_of = [&](uint32_t least) {
    double kept = 0;
    for (const uint32_t count : samples_of_mode) {
      if (count >= least) kept += count;
    }
    return kept / all;
  };
  uint32_t least = min_samples;
  while (least > 0 && all > 0 && share_of(least) < kMinKeptShare) --least;
  return all > 0 ? least : 0;
}

GrownTree TreeWithModes(std::span<const forest::Node> nodes,
                        const ModesOfLeaf& modes_of_leaf) {
  GrownTree tree;
  std::vector<uint32_t> modes(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (!nodes[i].is_leaf()) continue;
    const std::vector<GrownLeaf> leaves = modes_of_leaf(i);
    modes[i] = static_cast<uint32_t>(leaves.size());
    tree.leaves.insert(tree.leaves.end(), leaves.begin(), leaves.end());
  }
  // Children stand behind their parents; without recursion, since trees of
  // hostile files are deep.
  std::vector<uint8_t> has_modes(nodes.size());
  std::vector<uint8_t> is_kept(nodes.size());
  for (size_t i = nodes.size(); i-- > 0;) {
    if (nodes[i].is_leaf()) {
      has_modes[i] = is_kept[i] = modes[i] > 0 ? 1 : 0;
      continue;
    }
    const size_t right = i + nodes[i].right_offset();
    has_modes[i] = has_modes[i + 1] | has_modes[right];
    // Where one side is gone, the other takes the split's place.
    is_kept[i] = has_modes[i + 1] & has_modes[right];
  }
  std::vector<uint32_t> place(nodes.size());  // among those that are kept
  uint32_t kept = 0;
  for (size_t i = 0; i < nodes.size(); ++i) {
    place[i] = kept;
    kept += is_kept[i];
  }
  uint32_t next_mode = 0;
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (is_kept[i] == 0) continue;
    if (nodes[i].is_leaf()) {
      tree.nodes.push_back(forest::Node::Leaf(next_mode, modes[i]));
      next_mode += modes[i];
    } else {
      tree.nodes.push_back(
          forest::Node::Split(nodes[i].feature(), nodes[i].threshold(),
                              place[i + nodes[i].right_offset()] - place[i]));
    }
  }
  return tree;
}

GrownTree PruneTree(const GrownTree& tree, uint32_t min_samples) {
  std::vector<uint32_t> counts;
  for (const GrownLeaf& leaf : tree.leaves) counts.push_back(leaf.count);
  const uint32_t least = LeastKept(counts, min_samples);
  return TreeWithModes(tree.nodes, [&](size_t node) {
    const forest::Node& leaf = tree.nodes[node];
    std::vector<GrownLeaf> modes;
    for (uint32_t k = 0; k < leaf.modes(); ++k) {
      const GrownLeaf& mode = tree.leaves[leaf.leaf() + k];
      if (mode.count >= least) modes.push_back(mode);
    }
    return modes;
  });
}

}  // namespace treeline::training
