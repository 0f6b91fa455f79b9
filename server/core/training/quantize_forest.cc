#include "server/core/training/quantize_forest.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace treeline::training {
namespace {

uint16_t Quantized(double value, double low, double high) {
  return high > low ? static_cast<uint16_t>(
                          std::lround(65535 * (value - low) / (high - low)))
                    : uint16_t{0};
}

}  // namespace

forest::Forest QuantizeForest(std::vector<GrownTree> trees) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  geometry::Vec3 low{kInfinity, kInfinity, kInfinity};
  geometry::Vec3 high = -low;
  for (const GrownTree& tree : trees) {
    for (const GrownLeaf& leaf : tree.leaves) {
      const geometry::Vec3& m = leaf.mean_in_world;
      low = {std::min(low.x, m.x), std::min(low.y, m.y), std::min(low.z, m.z)};
      high = {std::max(high.x, m.x), std::max(high.y, m.y),
              std::max(high.z, m.z)};
    }
  }
  forest::Forest forest;
  forest.bounds_min_in_world = low;
  forest.bounds_max_in_world = high;
  for (GrownTree& tree : trees) {
    AppendNodes(tree.nodes, static_cast<uint32_t>(forest.payloads.size()),
                forest.nodes);
    forest.tree_offsets.push_back(static_cast<uint32_t>(forest.nodes.size()));
    for (const GrownLeaf& leaf : tree.leaves) {
      forest::LeafPayload payload;
      payload.mean = {Quantized(leaf.mean_in_world.x, low.x, high.x),
                      Quantized(leaf.mean_in_world.y, low.y, high.y),
                      Quantized(leaf.mean_in_world.z, low.z, high.z)};
      for (size_t k = 0; k < 6; ++k) {
        payload.covariance[k] = forest::ToBfloat16(leaf.covariance[k]);
      }
      payload.count =
          static_cast<uint16_t>(std::min<uint32_t>(leaf.count, 65535));
      forest.payloads.push_back(payload);
      forest.descriptors.push_back(leaf.descriptor);
    }
    tree = GrownTree{};
  }
  return forest;
}

GrownTree GrownTreeOf(const forest::ForestView& forest, int t) {
  GrownTree tree;
  for (forest::Node node : forest.tree(t)) {
    if (node.is_leaf()) {
      const uint32_t first = static_cast<uint32_t>(tree.leaves.size());
      for (uint32_t k = 0; k < node.modes(); ++k) {
        const uint32_t mode = node.leaf() + k;
        const forest::LeafPayload& payload = forest.payloads[mode];
        GrownLeaf leaf;
        leaf.mean_in_world = forest.LeafMean(mode);
        for (size_t c = 0; c < 6; ++c) {
          leaf.covariance[c] = forest::FromBfloat16(payload.covariance[c]);
        }
        leaf.count = payload.count;
        leaf.descriptor = forest.descriptors[mode];
        tree.leaves.push_back(leaf);
      }
      node = forest::Node::Leaf(first, node.modes());
    }
    tree.nodes.push_back(node);
  }
  return tree;
}

forest::Forest SplitsOf(const forest::ForestView& forest) {
  forest::Forest splits;
  splits.nodes.assign(forest.nodes.begin(), forest.nodes.end());
  for (forest::Node& node : splits.nodes) {
    if (node.is_leaf()) node = forest::Node::Leaf(0);
  }
  splits.tree_offsets.assign(forest.tree_offsets.begin(),
                             forest.tree_offsets.end());
  splits.payloads.emplace_back();
  splits.descriptors.emplace_back();
  splits.bounds_min_in_world = forest.bounds_min_in_world;
  splits.bounds_max_in_world = forest.bounds_max_in_world;
  return splits;
}

}  // namespace treeline::training
