#include "evaluation/accuracy/split_ratios.h"

#include <vector>

#include "gtest/gtest.h"

namespace treeline::accuracy {
namespace {

forest::Forest TwoLevels() {
  // Root: 30 left (of which 3 and 27), 10 right.
  forest::Forest forest;
  forest.nodes = {forest::Node::Split({}, 0, 4), forest::Node::Split({}, 0, 2),
                  forest::Node::Leaf(0), forest::Node::Leaf(1, 2),
                  forest::Node::Leaf(3)};
  forest.tree_offsets = {0, 5};
  forest.payloads.resize(4);
  forest.payloads[0].count = 3;
  forest.payloads[1].count = 20;  // the two modes of one leaf
  forest.payloads[2].count = 7;
  forest.payloads[3].count = 10;
  return forest;
}

TEST(SplitRatios, SumsTheSamplesOfTheLeavesBelow) {
  const forest::Forest forest = TwoLevels();
  const std::vector<LevelSplits> levels = SplitRatios(forest.View());
  ASSERT_EQ(levels.size(), 2u);
  EXPECT_EQ(levels[0].splits, 1);
  EXPECT_EQ(levels[0].by_left_share[15], 1);  // 30 / 40
  EXPECT_EQ(levels[1].by_left_share[2], 1);   // 3 / 30
}

TEST(SplitRatios, CountsAllTrees) {
  forest::Forest forest = TwoLevels();
  const std::vector<forest::Node> tree = forest.nodes;
  forest.nodes.insert(forest.nodes.end(), tree.begin(), tree.end());
  forest.tree_offsets.push_back(10);
  EXPECT_EQ(SplitRatios(forest.View())[0].by_left_share[15], 2);
}

TEST(SplitRatios, HasNoLevelForATreeOfOneLeaf) {
  forest::Forest forest;
  forest.nodes = {forest::Node::Leaf(0)};
  forest.tree_offsets = {0, 1};
  forest.payloads.resize(1);
  EXPECT_TRUE(SplitRatios(forest.View()).empty());
}

TEST(SplitRatios, PutsASplitThatSendsAllToTheLeftIntoTheLastBin) {
  forest::Forest forest;
  forest.nodes = {forest::Node::Split({}, 0, 2), forest::Node::Leaf(0),
                  forest::Node::Leaf(1)};
  forest.tree_offsets = {0, 3};
  forest.payloads.resize(2);
  forest.payloads[0].count = 4;
  EXPECT_EQ(SplitRatios(forest.View())[0].by_left_share.back(), 1);
}

}  // namespace
}  // namespace treeline::accuracy
