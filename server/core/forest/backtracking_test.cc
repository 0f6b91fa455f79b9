#include "server/core/forest/backtracking.h"

#include <algorithm>
#include <queue>
#include <set>
#include <tuple>

#include "common/base/random.h"
#include "common/base/testing_vector_targets.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::forest {
namespace {

image::ColorImage RandomImage(int width, int height, uint64_t seed) {
  image::ColorImage image{width, height, {}};
  base::Random random(seed, 0);
  image.rgb.resize(static_cast<size_t>(3 * width * height));
  for (uint8_t& value : image.rgb) {
    value = static_cast<uint8_t>(random.NextBelow(256));
  }
  return image;
}

// A random tree of `leaves` leaves, numbered from first_leaf on.
std::vector<Node> RandomTree(int leaves, uint32_t first_leaf,
                             base::Random& random) {
  if (leaves == 1) return {Node::Leaf(first_leaf)};
  const int left =
      1 + static_cast<int>(random.NextBelow(static_cast<uint32_t>(leaves - 1)));
  std::vector<Node> nodes(1);
  for (const Node& node : RandomTree(left, first_leaf, random)) {
    nodes.push_back(node);
  }
  features::PixelDifference feature;
  feature.dx =
      static_cast<int16_t>(static_cast<int>(random.NextBelow(1023)) - 511);
  feature.dy =
      static_cast<int16_t>(static_cast<int>(random.NextBelow(1023)) - 511);
  feature.c1 = static_cast<uint8_t>(random.NextBelow(3));
  feature.c2 = static_cast<uint8_t>(random.NextBelow(3));
  nodes[0] = Node::Split(feature, static_cast<int>(random.NextBelow(200)) - 100,
                         static_cast<uint32_t>(nodes.size()));
  for (const Node& node : RandomTree(
           leaves - left, first_leaf + static_cast<uint32_t>(left), random)) {
    nodes.push_back(node);
  }
  return nodes;
}

struct Samples {
  std::vector<int32_t> x, y, inverse_depth;
  SampleView View() const { return {x, y, inverse_depth}; }
};

Samples RandomSamples(int count, int width, int height, base::Random& random) {
  Samples samples;
  for (int i = 0; i < count; ++i) {
    samples.x.push_back(
        static_cast<int32_t>(random.NextBelow(static_cast<uint32_t>(width))));
    samples.y.push_back(
        static_cast<int32_t>(random.NextBelow(static_cast<uint32_t>(height))));
    samples.inverse_depth.push_back(
        static_cast<int32_t>(500 + random.NextBelow(8000)));
  }
  return samples;
}

// Algorithm 3 as the thesis has it, with a real priority queue.
std::vector<uint32_t> Algorithm3(const std::vector<Node>& tree,
                                 const features::PlanarImage& image, int32_t x,
                                 int32_t y, int32_t inverse_depth, int n_max) {
  using Entry = std::pair<int, size_t>;  // distance to the split, node
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  queue.push({0, 0});
  std::vector<uint32_t> leaves;
  while (!queue.empty() && static_cast<int>(leaves.size()) < n_max) {
    size_t node = queue.top().second;
    queue.pop();
    while (!tree[node].is_leaf()) {
      const int margin =
          features::Evaluate(tree[node].feature(), image, x, y, inverse_depth) -
          tree[node].threshold();
      const size_t left = node + 1;
      const size_t right = node + tree[node].right_offset();
      queue.push({std::abs(margin), margin <= 0 ? right : left});
      node = margin <= 0 ? left : right;
    }
    leaves.push_back(tree[node].leaf());
  }
  leaves.resize(static_cast<size_t>(n_max), kNoLeaf);
  return leaves;
}

class VisitLeavesTest : public testing::TestWithParam<int> {};

TEST_P(VisitLeavesTest, VisitsWhatAlgorithm3Visits) {
  const int n_max = GetParam();
  base::Random random(5, static_cast<uint64_t>(n_max));
  const features::PlanarImage image(RandomImage(80, 60, 6));
  base::WithEachVectorTarget([&] {
    for (int leaves : {1, 2, 3, 7, 50, 400}) {
      const std::vector<Node> tree = RandomTree(leaves, 0, random);
      // More samples than lanes of any machine, and not a multiple of them.
      const Samples samples = RandomSamples(101, 80, 60, random);
      std::vector<uint32_t> visited(101 * static_cast<size_t>(n_max), 12345);
      VisitLeaves(tree, image, samples.View(), n_max, visited);
      for (size_t i = 0; i < 101; ++i) {
        const auto begin =
            visited.begin() + static_cast<std::ptrdiff_t>(i) * n_max;
        EXPECT_EQ(std::vector<uint32_t>(begin, begin + n_max),
                  Algorithm3(tree, image, samples.x[i], samples.y[i],
                             samples.inverse_depth[i], n_max))
            << leaves << " leaves, sample " << i;
      }
    }
  });
}

INSTANTIATE_TEST_SUITE_P(UpToTheLimit, VisitLeavesTest,
                         testing::Values(1, 2, 3, 5, 8, 16, 31, 32));

TEST(VisitLeavesTest, SeesEveryLeafOfASmallTreeOnce) {
  base::Random random(7, 0);
  const features::PlanarImage image(RandomImage(80, 60, 8));
  const std::vector<Node> tree = RandomTree(32, 0, random);
  const Samples samples = RandomSamples(20, 80, 60, random);
  std::vector<uint32_t> visited(20 * 32);
  VisitLeaves(tree, image, samples.View(), 32, visited);
  for (size_t i = 0; i < 20; ++i) {
    const std::set<uint32_t> distinct(
        visited.begin() + static_cast<std::ptrdiff_t>(32 * i),
        visited.begin() + static_cast<std::ptrdiff_t>(32 * i + 32));
    EXPECT_EQ(distinct.size(), 32u);
    EXPECT_EQ(*distinct.rbegin(), 31u);
  }
}

TEST(VisitLeavesTest, NoSamplesIsNoWork) {
  const features::PlanarImage image(RandomImage(80, 60, 8));
  const std::vector<Node> tree = {Node::Leaf(0)};
  VisitLeaves(tree, image, {}, 4, {});
}

// A forest of random trees with random leaf descriptors.
Forest RandomForest(int trees, int leaves, base::Random& random) {
  Forest forest;
  for (int t = 0; t < trees; ++t) {
    for (const Node& node :
         RandomTree(leaves, static_cast<uint32_t>(t * leaves), random)) {
      forest.nodes.push_back(node);
    }
    forest.tree_offsets.push_back(static_cast<uint32_t>(forest.nodes.size()));
    for (int l = 0; l < leaves; ++l) {
      features::WhtDescriptor descriptor;
      for (size_t k = 0; k < 60; ++k) {
        descriptor.values[k] =
            static_cast<int8_t>(static_cast<int>(random.NextBelow(255)) - 127);
      }
      forest.descriptors.push_back(descriptor);
      forest.payloads.emplace_back();
    }
  }
  return forest;
}

TEST(PredictLeavesTest, WithAllLeavesVisitedFindsTheNearestOfAll) {
  base::Random random(9, 0);
  const features::PlanarImage image(RandomImage(200, 150, 10));
  const Forest forest = RandomForest(3, 32, random);
  ASSERT_TRUE(forest.View().Validate().ok());
  const Samples samples = RandomSamples(40, 200, 150, random);
  std::vector<features::WhtDescriptor> descriptors(40);
  for (features::WhtDescriptor& d : descriptors) {
    for (size_t k = 0; k < 60; ++k) {
      d.values[k] =
          static_cast<int8_t>(static_cast<int>(random.NextBelow(255)) - 127);
    }
  }
  std::vector<LeafMatch> matches(40 * 3);
  BacktrackingScratch scratch;
  PredictLeaves(forest.View(), image, samples.View(), descriptors,
                {.leaves = 32}, {}, scratch, matches);
  for (size_t i = 0; i < 40; ++i) {
    // Exhaustive search.
    uint32_t best = 0;
    for (uint32_t leaf = 0; leaf < forest.descriptors.size(); ++leaf) {
      if (features::SquaredDistance(descriptors[i], forest.descriptors[leaf]) <
          features::SquaredDistance(descriptors[i], forest.descriptors[best])) {
        best = leaf;
      }
    }
    EXPECT_EQ(matches[3 * i].leaf, best);
    std::set<uint32_t> of_trees;
    for (size_t t = 0; t < 3; ++t) {
      const LeafMatch& match = matches[3 * i + t];
      EXPECT_EQ(match.distance,
                features::SquaredDistance(descriptors[i],
                                          forest.descriptors[match.leaf]));
      of_trees.insert(match.leaf / 32);
      if (t > 0) {
        EXPECT_GE(match.distance, matches[3 * i + t - 1].distance);
      }
    }
    EXPECT_EQ(of_trees.size(), 3u) << "one match of each tree";
  }
}

TEST(PredictLeavesTest, LooksFurtherOnlyWhereTheFirstMatchIsPoor) {
  base::Random random(13, 0);
  const features::PlanarImage image(RandomImage(200, 150, 14));
  const Forest forest = RandomForest(2, 32, random);
  const Samples samples = RandomSamples(40, 200, 150, random);
  std::vector<features::WhtDescriptor> descriptors(40);
  for (features::WhtDescriptor& d : descriptors) {
    for (size_t k = 0; k < 60; ++k) {
      d.values[k] =
          static_cast<int8_t>(static_cast<int>(random.NextBelow(255)) - 127);
    }
  }
  BacktrackingScratch scratch;
  const auto predict = [&](const BacktrackingOptions& options) {
    std::vector<LeafMatch> matches(40 * 2);
    PredictLeaves(forest.View(), image, samples.View(), descriptors, options,
                  {}, scratch, matches);
    return matches;
  };
  const std::vector<LeafMatch> few = predict({.leaves = 2});
  const std::vector<LeafMatch> many = predict({.leaves = 16});
  // Half of the samples are content with two leaves.
  std::vector<int32_t> distances;
  for (size_t i = 0; i < 40; ++i) distances.push_back(few[2 * i].distance);
  std::ranges::sort(distances);
  const int32_t good = distances[20];
  const std::vector<LeafMatch> by_need =
      predict({.leaves = 16, .first_leaves = 2, .good_squared_distance = good});
  int content = 0;
  for (size_t i = 0; i < 40; ++i) {
    const bool is_good = few[2 * i].distance <= good;
    content += is_good;
    const std::vector<LeafMatch>& expected = is_good ? few : many;
    for (size_t t = 0; t < 2; ++t) {
      EXPECT_EQ(by_need[2 * i + t].leaf, expected[2 * i + t].leaf);
      EXPECT_EQ(by_need[2 * i + t].distance, expected[2 * i + t].distance);
    }
  }
  EXPECT_GE(content, 20);
  EXPECT_LT(content, 40);
}

TEST(PredictLeavesTest, ReturnsAtOnceWhenStopped) {
  base::Random random(11, 0);
  const features::PlanarImage image(RandomImage(80, 60, 12));
  const Forest forest = RandomForest(1, 8, random);
  const Samples samples = RandomSamples(10, 80, 60, random);
  const std::vector<features::WhtDescriptor> descriptors(10);
  std::vector<LeafMatch> matches(10);
  BacktrackingScratch scratch;
  std::stop_source stop;
  stop.request_stop();
  PredictLeaves(forest.View(), image, samples.View(), descriptors,
                {.leaves = 4}, stop.get_token(), scratch, matches);
  for (const LeafMatch& match : matches) EXPECT_EQ(match.leaf, kNoLeaf);
}

}  // namespace
}  // namespace treeline::forest
