#include "common/dataset/frame_use.h"

#include <algorithm>

#include "gtest/gtest.h"

namespace treeline::dataset {
namespace {

TEST(UseOfFrameTest, HeldOutFramesAreNoNeighboursOfTrainingFrames) {
  constexpr int kFrames = 1000;
  int train = 0;
  int test = 0;
  for (int i = 0; i < kFrames; ++i) {
    const FrameUse use = UseOfFrame(i, kFrames);
    train += use == FrameUse::kTrain ? 1 : 0;
    if (use != FrameUse::kTest) continue;
    ++test;
    for (int j = std::max(0, i - 10); j <= std::min(kFrames - 1, i + 10); ++j) {
      ASSERT_NE(UseOfFrame(j, kFrames), FrameUse::kTrain) << i << ", " << j;
    }
  }
  EXPECT_EQ(train, 600);
  EXPECT_EQ(test, 200);
}

TEST(UseOfFrameTest, ShortRecordingsHaveBothParts) {
  for (int frames = 5; frames < 300; ++frames) {
    int train = 0;
    int test = 0;
    for (int i = 0; i < frames; ++i) {
      train += UseOfFrame(i, frames) == FrameUse::kTrain ? 1 : 0;
      test += UseOfFrame(i, frames) == FrameUse::kTest ? 1 : 0;
    }
    ASSERT_GT(train, 0) << frames;
    ASSERT_GT(test, 0) << frames;
  }
}

}  // namespace
}  // namespace treeline::dataset
