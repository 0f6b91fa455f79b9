#include "server/core/training/sample_memory.h"

#include <filesystem>

#include "common/base/testing_folder.h"
#include "gtest/gtest.h"

namespace treeline::training {
namespace {

// Samples of two trees that tell which frame they are of.
std::vector<RoutedSamples> OfFrame(int frame) {
  std::vector<RoutedSamples> by_tree(2);
  for (int tree = 0; tree < 2; ++tree) {
    RoutedSamples& samples = by_tree[static_cast<size_t>(tree)];
    for (int i = 0; i < 3 * tree + frame; ++i) {
      samples.leaf.push_back(static_cast<uint32_t>(100 * frame + i));
      samples.point.push_back({static_cast<float>(i), 2, 3});
      samples.descriptor.emplace_back();
      samples.descriptor.back().values[7] = static_cast<int8_t>(frame);
    }
  }
  return by_tree;
}

TEST(SampleMemory, GivesBackWhatWasAddedAndLeavesNoFile) {
  const base::TestingFolder folder;
  {
    const auto memory = SampleMemory::Open(folder.Path(""));
    ASSERT_TRUE(memory.ok()) << memory.status();
    for (int frame = 0; frame < 5; ++frame) {
      ASSERT_TRUE((*memory)->Add(OfFrame(frame)).ok());
    }
    EXPECT_EQ((*memory)->size(), 5);
    for (const int frame : {4, 0, 2}) {
      for (int tree = 0; tree < 2; ++tree) {
        const RoutedSamples added = OfFrame(frame)[static_cast<size_t>(tree)];
        const auto read = (*memory)->Read(static_cast<size_t>(frame), tree);
        ASSERT_TRUE(read.ok()) << read.status();
        EXPECT_EQ(read->leaf, added.leaf);
        ASSERT_EQ(read->point.size(), added.point.size());
        for (size_t i = 0; i < read->size(); ++i) {
          EXPECT_EQ(read->point[i].x, added.point[i].x);
          EXPECT_EQ(read->descriptor[i].values, added.descriptor[i].values);
        }
      }
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder.Path("")));
  }
}

TEST(SampleMemory, SaysWhereNoFileCanBe) {
  const auto memory = SampleMemory::Open("/nowhere/at/all");
  EXPECT_TRUE(absl::IsUnavailable(memory.status()));
}

}  // namespace
}  // namespace treeline::training
