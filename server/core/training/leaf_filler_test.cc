#include "server/core/training/leaf_filler.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::training {
namespace {

// A tree of one leaf, that of another scene.
forest::Forest OneLeaf() {
  forest::Forest base;
  base.nodes = {forest::Node::Leaf(0)};
  base.tree_offsets = {0, 1};
  base.payloads.emplace_back();
  base.descriptors.emplace_back();
  return base;
}

// Samples at these places along the x axis (m), all in the one leaf.
RoutedSamples At(const std::vector<float>& places) {
  RoutedSamples samples;
  for (const float x : places) {
    samples.leaf.push_back(0);
    samples.point.push_back({x, 0, 0});
    samples.descriptor.emplace_back();
  }
  return samples;
}

uint32_t CountNear(const GrownTree& tree, double x_m) {
  for (const GrownLeaf& leaf : tree.leaves) {
    if (std::abs(leaf.mean_in_world.x - x_m) < 0.05) return leaf.count;
  }
  return 0;
}

TEST(LeafFiller, GathersWhatLiesTogether) {
  const forest::Forest base = OneLeaf();
  LeafFiller filler(base.View(), Refill::kAdapt, 0);
  filler.Add(0, At({1, 1.02F, 5, 1.04F}));
  filler.Add(0, At({5.02F, 9}));
  const GrownTree tree = filler.Assemble(0);
  ASSERT_EQ(tree.leaves.size(), 3);
  EXPECT_EQ(tree.leaves[0].count, 3);
  EXPECT_NEAR(tree.leaves[0].mean_in_world.x, 1.02, 1e-6);
  EXPECT_EQ(CountNear(tree, 5.01), 2);
  EXPECT_EQ(CountNear(tree, 9), 1);
}

TEST(LeafFiller, IsEmptyBeforeAnySample) {
  const forest::Forest base = OneLeaf();
  const LeafFiller filler(base.View(), Refill::kAdapt, 24);
  EXPECT_TRUE(filler.Assemble(0).leaves.empty());
}

TEST(LeafFiller, LeavesOutSmallModes) {
  const forest::Forest base = OneLeaf();
  LeafFiller filler(base.View(), Refill::kAdapt, 24);
  filler.Add(0, At({1, 1, 1, 1, 1, 5, 5}));
  EXPECT_EQ(filler.Assemble(0, 5).leaves.size(), 1);
  EXPECT_EQ(filler.Assemble(0, 2).leaves.size(), 2);
}

// A long recording: what is seen again and again stays, whatever passes by.
TEST(LeafFiller, KeepsWhatIsSeenOftenWhereALeafIsFull) {
  const forest::Forest base = OneLeaf();
  LeafFiller filler(base.View(), Refill::kAdapt, 16);
  std::vector<float> often(10, 1.0F);
  filler.Add(0, At(often));
  for (int round = 0; round < 50; ++round) {
    std::vector<float> once;
    for (int i = 0; i < 20; ++i) {
      once.push_back(static_cast<float>(10 + 20 * round + i));
    }
    filler.Add(0, At(once));
    filler.Add(0, At({1.0F}));
  }
  const GrownTree tree = filler.Assemble(0);
  EXPECT_LE(tree.leaves.size(), 16);
  EXPECT_EQ(CountNear(tree, 1), 60);
}

// The room changes: what is no longer seen makes room for what is.
TEST(LeafFiller, GivesUpWhatIsNotSeenAnyMore) {
  const forest::Forest base = OneLeaf();
  LeafFiller filler(base.View(), Refill::kAdapt, 16);
  std::vector<float> before;
  for (int i = 0; i < 16; ++i) {
    before.push_back(static_cast<float>(i));
    before.push_back(static_cast<float>(i));
  }
  filler.Add(0, At(before));
  filler.Add(0, At(std::vector<float>(100, 50.0F)));
  EXPECT_GT(CountNear(filler.Assemble(0), 50), 90);
}

// No recording is too long for the sums of a mode.
TEST(LeafFiller, DoesNotOverflow) {
  const forest::Forest base = OneLeaf();
  LeafFiller filler(base.View(), Refill::kAdapt, 16);
  RoutedSamples many = At(std::vector<float>(1 << 16, 2.0F));
  for (features::WhtDescriptor& d : many.descriptor) d.values.fill(-127);
  for (int i = 0; i < 70; ++i) filler.Add(0, many);
  const GrownTree tree = filler.Assemble(0);
  ASSERT_EQ(tree.leaves.size(), 1);
  EXPECT_NEAR(tree.leaves[0].mean_in_world.x, 2, 1e-9);
  EXPECT_EQ(tree.leaves[0].descriptor.values[63], -127);
}

}  // namespace
}  // namespace treeline::training
