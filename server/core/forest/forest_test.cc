#include "server/core/forest/forest.h"

#include <cmath>

#include "gtest/gtest.h"

namespace treeline::forest {
namespace {

TEST(NodeTest, KeepsItsFieldsAtTheirLimits) {
  for (int delta : {-511, -1, 0, 1, 511}) {
    for (int threshold : {-256, -1, 0, 255}) {
      for (uint32_t offset : {2u, 77u, (1u << 23) - 2}) {
        const features::PixelDifference feature{
            static_cast<int16_t>(delta), static_cast<int16_t>(-delta), 2, 1};
        const Node node = Node::Split(feature, threshold, offset);
        EXPECT_FALSE(node.is_leaf());
        EXPECT_EQ(node.threshold(), threshold);
        EXPECT_EQ(node.right_offset(), offset);
        EXPECT_EQ(node.feature().dx, delta);
        EXPECT_EQ(node.feature().dy, -delta);
        EXPECT_EQ(node.feature().c1, 2);
        EXPECT_EQ(node.feature().c2, 1);
      }
    }
  }
  constexpr uint32_t kLastMode = (1u << 27) - 1;
  for (const uint32_t modes : {1u, 2u, Node::kMaxModes}) {
    EXPECT_TRUE(Node::Leaf(kLastMode, modes).is_leaf());
    EXPECT_EQ(Node::Leaf(kLastMode, modes).leaf(), kLastMode);
    EXPECT_EQ(Node::Leaf(kLastMode, modes).modes(), modes);
  }
}

TEST(Bfloat16Test, KeepsThreeDigits) {
  for (float value : {1e-6f, 0.0004f, 0.123f, 1.0f, 37.5f, -0.002f}) {
    EXPECT_NEAR(FromBfloat16(ToBfloat16(value)), value, std::abs(value) / 256);
  }
}

Forest TwoLeaves() {
  Forest forest;
  forest.nodes = {Node::Split({1, 2, 0, 1}, 5, 2), Node::Leaf(0),
                  Node::Leaf(1)};
  forest.tree_offsets = {0, 3};
  forest.descriptors.resize(2);
  forest.payloads.resize(2);
  forest.bounds_min_in_world = {-1, 0, 2};
  forest.bounds_max_in_world = {1, 0, 5};
  return forest;
}

TEST(ForestViewTest, PlacesLeavesWithinTheBounds) {
  Forest forest = TwoLeaves();
  forest.payloads[1].mean = {65535, 7, 21845};
  EXPECT_EQ(forest.View().LeafMean(0), (geometry::Vec3{-1, 0, 2}));
  EXPECT_NEAR(forest.View().LeafMean(1).x, 1, 1e-12);
  EXPECT_NEAR(forest.View().LeafMean(1).y, 0, 1e-12);
  EXPECT_NEAR(forest.View().LeafMean(1).z, 3, 1e-12);
}

TEST(ForestViewTest, AcceptsASoundForest) {
  EXPECT_TRUE(TwoLeaves().View().Validate().ok());
}

TEST(ForestViewTest, RefusesWhatPredictionWouldTripOver) {
  const auto code = [](const Forest& forest) {
    return forest.View().Validate().code();
  };
  constexpr auto kDataLoss = absl::StatusCode::kDataLoss;
  Forest forest = TwoLeaves();
  forest.nodes[2] = Node::Leaf(2);  // no such leaf
  EXPECT_EQ(code(forest), kDataLoss);
  forest = TwoLeaves();
  forest.nodes[0] = Node::Split({1, 2, 0, 1}, 5, 3);  // beyond the tree
  EXPECT_EQ(code(forest), kDataLoss);
  forest = TwoLeaves();
  forest.nodes[0] = Node::Split({1, 2, 0, 1}, 5, 1);  // both children the same
  EXPECT_EQ(code(forest), kDataLoss);
  forest = TwoLeaves();
  forest.nodes[0] = Node::Split({1, 2, 0, 3}, 5, 2);  // no such channel
  EXPECT_EQ(code(forest), kDataLoss);
  forest = TwoLeaves();
  forest.nodes.pop_back();
  EXPECT_EQ(code(forest), kDataLoss);
  forest = TwoLeaves();
  forest.tree_offsets = {0, 0, 3};  // a tree without nodes
  EXPECT_EQ(code(forest), kDataLoss);
  forest = TwoLeaves();
  forest.tree_offsets = {0, 2, 1, 3};
  EXPECT_EQ(code(forest), kDataLoss);
  forest = TwoLeaves();
  forest.descriptors.pop_back();
  EXPECT_EQ(code(forest), kDataLoss);
  forest = TwoLeaves();
  forest.bounds_max_in_world.x = std::nan("");
  EXPECT_EQ(code(forest), kDataLoss);
}

}  // namespace
}  // namespace treeline::forest
