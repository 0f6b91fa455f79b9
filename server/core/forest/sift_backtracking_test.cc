#include "server/core/forest/sift_backtracking.h"

#include <algorithm>
#include <cstdlib>
#include <set>
#include <utility>
#include <vector>

#include "common/base/random.h"
#include "common/base/testing_vector_targets.h"
#include "gtest/gtest.h"

namespace treeline::forest {
namespace {

features::SiftDescriptor RandomDescriptor(base::Random& random) {
  features::SiftDescriptor descriptor;
  for (uint8_t& value : descriptor.values) {
    value = static_cast<uint8_t>(random.NextBelow(256));
  }
  return descriptor;
}

// Appends a random subtree; its leaves have one to four modes.
void Grow(base::Random& random, int depth, Forest& forest) {
  if (depth == 0 || random.NextBelow(8) == 0) {
    const uint32_t modes = 1 + random.NextBelow(4);
    forest.nodes.push_back(Node::Leaf(
        static_cast<uint32_t>(forest.sift_descriptors.size()), modes));
    for (uint32_t m = 0; m < modes; ++m) {
      forest.sift_descriptors.push_back(RandomDescriptor(random));
      LeafPayload payload;
      for (uint16_t& x : payload.mean) {
        x = static_cast<uint16_t>(random.NextBelow(65536));
      }
      forest.payloads.push_back(payload);
    }
    return;
  }
  const size_t self = forest.nodes.size();
  forest.nodes.emplace_back();
  const auto dimension = static_cast<int16_t>(random.NextBelow(128));
  const int threshold = static_cast<int>(random.NextBelow(256)) - 128;
  Grow(random, depth - 1, forest);
  forest.nodes[self] =
      Node::Split({.dx = dimension}, threshold,
                  static_cast<uint32_t>(forest.nodes.size() - self));
  Grow(random, depth - 1, forest);
}

Forest RandomForest(int trees, int depth) {
  base::Random random(7, 0);
  Forest forest;
  for (int t = 0; t < trees; ++t) {
    Grow(random, depth, forest);
    forest.tree_offsets.push_back(static_cast<uint32_t>(forest.nodes.size()));
  }
  forest.bounds_max_in_world = {1, 1, 1};
  EXPECT_TRUE(forest.View().Validate().ok());
  return forest;
}

// Algorithm 3 word for word: an unbounded queue of (margin, node).
std::vector<uint32_t> ReferenceLeaves(
    std::span<const Node> tree, const features::SiftDescriptor& descriptor,
    size_t count) {
  std::set<std::pair<int, uint32_t>> queue = {{0, 0}};
  std::vector<uint32_t> leaves;
  while (!queue.empty() && leaves.size() < count) {
    uint32_t at = queue.begin()->second;
    queue.erase(queue.begin());
    while (!tree[at].is_leaf()) {
      const Node& node = tree[at];
      const auto dimension = static_cast<size_t>(node.feature().dx);
      const int margin = descriptor.values[dimension] - 128 - node.threshold();
      const uint32_t left = at + 1;
      const uint32_t right = at + node.right_offset();
      queue.insert({std::abs(margin), margin > 0 ? left : right});
      at = margin > 0 ? right : left;
    }
    leaves.push_back(tree[at].lo);
  }
  return leaves;
}

int32_t ReferenceDistance(const features::SiftDescriptor& a,
                          const features::SiftDescriptor& b) {
  int32_t sum = 0;
  for (size_t k = 0; k < a.values.size(); ++k) {
    const int32_t d = a.values[k] - b.values[k];
    sum += d * d;
  }
  return sum;
}

TEST(SiftBacktrackingTest, DistancesAreExact) {
  base::Random random(1, 0);
  features::SiftDescriptor zero;
  features::SiftDescriptor full;
  full.values.fill(255);
  base::WithEachVectorTarget([&] {
    EXPECT_EQ(SquaredDistance(zero, full), 128 * 255 * 255);
    for (int i = 0; i < 100; ++i) {
      const features::SiftDescriptor a = RandomDescriptor(random);
      const features::SiftDescriptor b = RandomDescriptor(random);
      EXPECT_EQ(SquaredDistance(a, b), ReferenceDistance(a, b));
    }
  });
}

TEST(SiftBacktrackingTest, VisitsTheLeavesOfAlgorithm3InItsOrder) {
  const Forest forest = RandomForest(3, 8);
  base::Random random(2, 0);
  for (int i = 0; i < 100; ++i) {
    const features::SiftDescriptor descriptor = RandomDescriptor(random);
    for (const size_t count : {1u, 2u, 7u, 32u}) {
      for (int t = 0; t < 3; ++t) {
        const std::span<const Node> tree = forest.View().tree(t);
        std::vector<uint32_t> leaves(count);
        leaves.resize(VisitSiftLeaves(tree, descriptor, leaves));
        EXPECT_EQ(leaves, ReferenceLeaves(tree, descriptor, count));
      }
    }
  }
}

TEST(SiftBacktrackingTest, ATreeOfOneLeafHasOne) {
  const std::vector<Node> tree = {Node::Leaf(5, 2)};
  std::vector<uint32_t> leaves(4);
  ASSERT_EQ(VisitSiftLeaves(tree, {}, leaves), 1u);
  EXPECT_EQ(leaves[0], tree[0].lo);
}

TEST(SiftBacktrackingTest, FindsTheNearestModeAndTheNearestElsewhere) {
  const Forest forest = RandomForest(5, 7);
  const ForestView view = forest.View();
  base::Random random(3, 0);
  std::vector<features::SiftDescriptor> descriptors;
  // More than a chunk, so that its borders are crossed.
  for (int i = 0; i < 150; ++i) {
    descriptors.push_back(RandomDescriptor(random));
  }
  const SiftSearchOptions options{.leaves_per_tree = 4, .same_place = 0.4};
  std::vector<uint32_t> which;
  for (uint32_t i = 0; i < 150; ++i) {
    if (i % 5 != 0) which.push_back(i);
  }
  std::vector<SiftMatch> matches(descriptors.size());
  MatchSift(view, descriptors, which, options, {}, matches);
  for (size_t i = 0; i < descriptors.size(); ++i) {
    if (i % 5 == 0) {
      EXPECT_EQ(matches[i].mode, kNoLeaf) << "was not asked for";
      continue;
    }
    std::vector<std::pair<int32_t, uint32_t>> modes;
    for (int t = 0; t < view.trees(); ++t) {
      for (const uint32_t leaf :
           ReferenceLeaves(view.tree(t), descriptors[i], 4)) {
        for (uint32_t m = 0; m < Node::Modes(leaf); ++m) {
          const uint32_t mode = Node::FirstMode(leaf) + m;
          modes.emplace_back(
              ReferenceDistance(descriptors[i], forest.sift_descriptors[mode]),
              mode);
        }
      }
    }
    std::ranges::sort(modes);
    ASSERT_EQ(matches[i].mode, modes[0].second);
    EXPECT_EQ(matches[i].distance, modes[0].first);
    const auto elsewhere = std::ranges::find_if(modes, [&](const auto& mode) {
      return geometry::Norm(view.LeafMean(mode.second) -
                            view.LeafMean(modes[0].second)) > 0.4;
    });
    EXPECT_EQ(matches[i].distance_elsewhere, elsewhere == modes.end()
                                                 ? SiftMatch::kNothingElsewhere
                                                 : elsewhere->first);
  }
}

TEST(SiftBacktrackingTest, AStopLeavesTheRestAsItWas) {
  const Forest forest = RandomForest(1, 3);
  std::stop_source stop;
  stop.request_stop();
  std::vector<SiftMatch> matches(2);
  const std::vector<features::SiftDescriptor> descriptors(2);
  const std::vector<uint32_t> which = {0, 1};
  MatchSift(forest.View(), descriptors, which, {}, stop.get_token(), matches);
  EXPECT_EQ(matches[0].mode, kNoLeaf);
}

}  // namespace
}  // namespace treeline::forest
