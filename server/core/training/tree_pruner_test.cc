#include "server/core/training/tree_pruner.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::training {
namespace {

using forest::Node;
using testing::ElementsAre;

// Modes that are told apart by their number of samples.
GrownTree TreeOf(std::vector<Node> nodes, const std::vector<uint32_t>& counts) {
  GrownTree tree{std::move(nodes), {}};
  for (const uint32_t count : counts) {
    tree.leaves.emplace_back();
    tree.leaves.back().count = count;
  }
  return tree;
}

std::vector<uint32_t> CountsOf(const GrownTree& tree) {
  std::vector<uint32_t> counts;
  for (const GrownLeaf& leaf : tree.leaves) counts.push_back(leaf.count);
  return counts;
}

Node Split(int16_t dx, uint32_t right) {
  return Node::Split({dx, 0, 0, 0}, 0, right);
}

// 1( 2( 7, 3 ), 3( 4( 2, 9 ), 5 ) ), splits named by dx.
GrownTree SomeTree() {
  return TreeOf(
      {Split(1, 4), Split(2, 2), Node::Leaf(0), Node::Leaf(1), Split(3, 4),
       Split(4, 2), Node::Leaf(2), Node::Leaf(3), Node::Leaf(4)},
      {7, 3, 2, 9, 5});
}

TEST(TreePrunerTest, TheOtherSideTakesTheSplitsPlace) {
  const GrownTree pruned = PruneTree(SomeTree(), 5);
  EXPECT_THAT(CountsOf(pruned), ElementsAre(7, 9, 5));
  ASSERT_EQ(pruned.nodes.size(), 5u);
  EXPECT_EQ(pruned.nodes[0].feature().dx, 1);
  EXPECT_EQ(pruned.nodes[0].right_offset(), 2u);
  EXPECT_EQ(pruned.nodes[1].leaf(), 0u);
  EXPECT_EQ(pruned.nodes[2].feature().dx, 3);
  EXPECT_EQ(pruned.nodes[3].leaf(), 1u);
  EXPECT_EQ(pruned.nodes[4].leaf(), 2u);
}

TEST(TreePrunerTest, ASideThatIsGoneTakesItsSplitsAlong) {
  EXPECT_THAT(CountsOf(PruneTree(SomeTree(), 6)), ElementsAre(7, 9));
  const GrownTree one = PruneTree(SomeTree(), 9);
  EXPECT_THAT(CountsOf(one), ElementsAre(9));
  EXPECT_EQ(one.nodes.size(), 1u);
  EXPECT_TRUE(one.nodes[0].is_leaf());
}

TEST(TreePrunerTest, AQuarterOfTheSamplesStaysWhateverIsAskedFor) {
  // 9 of 26 are more than a quarter.
  EXPECT_THAT(CountsOf(PruneTree(SomeTree(), 1000)), ElementsAre(9));
  const GrownTree alike =
      TreeOf({Split(1, 4), Split(2, 2), Node::Leaf(0), Node::Leaf(1),
              Split(3, 2), Node::Leaf(2), Node::Leaf(3)},
             {2, 2, 2, 3});
  EXPECT_THAT(CountsOf(PruneTree(alike, 5)), ElementsAre(3));
  // 5 of 29 are not.
  const GrownTree many = TreeOf({Split(1, 2), Node::Leaf(0),  //
                                 Split(1, 2), Node::Leaf(1, 12)},
                                {5, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2});
  EXPECT_EQ(CountsOf(PruneTree(many, 5)).size(), 13u);
  EXPECT_THAT(CountsOf(PruneTree(TreeOf({Node::Leaf(0)}, {0}), 5)),
              ElementsAre(0));
}

TEST(TreePrunerTest, NothingChangesBelowTheLeastAndTheSecondTime) {
  const GrownTree all = PruneTree(SomeTree(), 2);
  EXPECT_THAT(CountsOf(all), ElementsAre(7, 3, 2, 9, 5));
  EXPECT_EQ(all.nodes.size(), 9u);
  const GrownTree once = PruneTree(SomeTree(), 5);
  const GrownTree twice = PruneTree(once, 5);
  EXPECT_EQ(CountsOf(once), CountsOf(twice));
  EXPECT_EQ(once.nodes.size(), twice.nodes.size());
}

TEST(TreePrunerTest, OfALeafsModesThoseWithEnoughStay) {
  const GrownTree tree = TreeOf(
      {Split(1, 2), Node::Leaf(0, 3), Node::Leaf(3, 2)}, {8, 1, 6, 2, 1});
  const GrownTree pruned = PruneTree(tree, 6);
  EXPECT_THAT(CountsOf(pruned), ElementsAre(8, 6));
  ASSERT_EQ(pruned.nodes.size(), 1u);
  EXPECT_EQ(pruned.nodes[0].modes(), 2u);
}

}  // namespace
}  // namespace treeline::training
