#include "evaluation/accuracy/split_ratios.h"

#include <algorithm>
#include <span>

namespace treeline::accuracy {
namespace {

int64_t LeafSamples(const forest::ForestView& forest,
                    const forest::Node& leaf) {
  int64_t samples = 0;
  for (uint32_t k = 0; k < leaf.modes(); ++k) {
    samples += forest.payloads[leaf.leaf() + k].count;
  }
  return samples;
}

void AddTree(const forest::ForestView& forest,
             std::span<const forest::Node> tree,
             std::vector<LevelSplits>& levels) {
  // Children stand behind their parents: samples are summed from the end,
  // levels counted from the beginning.
  std::vector<int64_t> samples(tree.size());
  for (size_t i = tree.size(); i-- > 0;) {
    samples[i] = tree[i].is_leaf()
                     ? LeafSamples(forest, tree[i])
                     : samples[i + 1] + samples[i + tree[i].right_offset()];
  }
  std::vector<size_t> level(tree.size());
  for (size_t i = 0; i < tree.size(); ++i) {
    if (tree[i].is_leaf()) continue;
    level[i + 1] = level[i + tree[i].right_offset()] = level[i] + 1;
    if (samples[i] == 0) continue;
    if (levels.size() <= level[i]) levels.resize(level[i] + 1);
    const int64_t bin = kSplitRatioBins * samples[i + 1] / samples[i];
    ++levels[level[i]].splits;
    ++levels[level[i]].by_left_share[static_cast<size_t>(
        std::min<int64_t>(bin, kSplitRatioBins - 1))];
  }
}

}  // namespace

std::vector<LevelSplits> SplitRatios(const forest::ForestView& forest) {
  std::vector<LevelSplits> levels;
  for (int t = 0; t < forest.trees(); ++t) {
    AddTree(forest, forest.tree(t), levels);
  }
  return levels;
}

}  // namespace treeline::accuracy
