#include "evaluation/accuracy/sweep.h"

#include <filesystem>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/forest/model_file.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ParseSweep, TakesRangesStepsAndLists) {
  const SweepRequest range = *ParseSweep("backtracking=1..4");
  EXPECT_EQ(range.variable, SweepVariable::kBacktracking);
  EXPECT_THAT(range.values, ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(ParseSweep("samples=100..300:100")->values,
              ElementsAre(100, 200, 300));
  EXPECT_THAT(ParseSweep("hypotheses=64,16,64")->values, ElementsAre(16, 64));
  EXPECT_THAT(ParseSweep("balanced-levels=0..10:4")->values,
              ElementsAre(0, 4, 8));
}

TEST(ParseSweep, RefusesWhatIsNoSweep) {
  for (const char* text :
       {"", "backtracking", "backtracking=", "leaves=1..2", "trees=3..1",
        "trees=1..", "trees=1..x", "trees=1..4:0",
        "trees=1..4:", "samples=1,2,x", "samples=30..20000"}) {
    EXPECT_EQ(ParseSweep(text).status().code(),
              absl::StatusCode::kInvalidArgument)
        << text;
  }
}

TEST(ParseSweep, RefusesValuesThatTheOptionDoesNotAllow) {
  EXPECT_THAT(std::string(ParseSweep("backtracking=0..4").status().message()),
              HasSubstr("backtracking"));
  EXPECT_FALSE(ParseSweep("backtracking=1..33").ok());
  EXPECT_FALSE(ParseSweep("trees=0,1").ok());
}

// Tree 0 is one leaf of two modes, tree 1 a split.
forest::Forest TwoTrees() {
  forest::Forest forest;
  forest.nodes = {forest::Node::Leaf(0, 2), forest::Node::Split({}, 0, 2),
                  forest::Node::Leaf(2), forest::Node::Leaf(3)};
  forest.tree_offsets = {0, 1, 4};
  forest.payloads.resize(4);
  forest.payloads[1].count = 17;
  forest.descriptors.resize(4);
  forest.bounds_max_in_world = {1, 1, 1};
  return forest;
}

TEST(WriteFirstTrees, KeepsTheirNodesModesAndEverythingElse) {
  const tools::TestFolder folder;
  const forest::Forest forest = TwoTrees();
  forest::ModelInfo info;
  info.method = "rgbd";
  ASSERT_TRUE(
      forest::WriteModel(folder / "two", info, {forest.View()},
                         std::vector<forest::ModelExtraBytes>{
                             {forest::ModelExtra::kKeyframes, "0123456789"}})
          .ok());
  ASSERT_TRUE(WriteFirstTrees(folder / "two", 1, folder / "one").ok());
  const auto model = forest::ModelFile::Open(folder / "one");
  ASSERT_TRUE(model.ok()) << model.status();
  const forest::ForestView& cut = (*model)->forest();
  EXPECT_EQ(cut.trees(), 1);
  EXPECT_EQ(cut.nodes.size(), 1u);
  EXPECT_EQ(cut.payloads.size(), 2u);
  EXPECT_EQ(cut.descriptors.size(), 2u);
  EXPECT_EQ(cut.payloads[1].count, 17);
  EXPECT_EQ((*model)->info().method, "rgbd");
  EXPECT_EQ((*model)->Extra<char>(forest::ModelExtra::kKeyframes)->size(), 10u);
}

TEST(WriteFirstTrees, RefusesMoreTreesThanThereAre) {
  const tools::TestFolder folder;
  const forest::Forest forest = TwoTrees();
  ASSERT_TRUE(forest::WriteModel(folder / "two", {}, {forest.View()}).ok());
  const absl::Status status =
      WriteFirstTrees(folder / "two", 3, folder / "three");
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("has 2 trees"));
  EXPECT_FALSE(std::filesystem::exists(folder / "three"));
  EXPECT_EQ(WriteFirstTrees(folder / "none", 1, folder / "x").code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace treeline::accuracy
