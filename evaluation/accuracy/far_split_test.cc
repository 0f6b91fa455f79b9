#include "evaluation/accuracy/far_split.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/training/box_room_recording.h"

namespace treeline::accuracy {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

FramePoses Loop(int count) {
  FramePoses poses;
  for (const geometry::Rigid3& pose : training::BoxRoomPoses(count)) {
    poses.emplace_back(pose);
  }
  return poses;
}

void ExpectFarApart(const FarSplit& split, const FramePoses& poses,
                    const ViewLimits& near) {
  for (const int test : split.test) {
    for (const int training : split.training) {
      EXPECT_GT(ViewGap(*poses[static_cast<size_t>(test)],
                        *poses[static_cast<size_t>(training)], near),
                1)
          << test << " and " << training;
    }
  }
}

TEST(SplitAfterFirst, TestsWhatIsBeyondEitherLimit) {
  const auto at = [](double x, double angle_deg) {
    return geometry::Rigid3{
        geometry::Rotation3::FromAxisAngle({0, angle_deg * 0.017453293, 0}),
        {x, 0, 0}};
  };
  const FramePoses poses{at(0, 0),   std::nullopt, at(0.2, 0), at(0.4, 10),
                         at(0.6, 0), at(0, 14),    at(0, 16),  std::nullopt};
  const FarSplit split = SplitAfterFirst(poses, 2, {0.3, 15});
  EXPECT_THAT(split.training, ElementsAre(0, 2));
  EXPECT_THAT(split.test, ElementsAre(4, 6));
}

TEST(SplitByHoles, LeavesNoTrainingFrameNearATestFrame) {
  const auto poses = Loop(600);
  const HoleOptions options;
  const FarSplit split = SplitByHoles(poses, options);
  EXPECT_GE(split.training.size(), 240u);
  EXPECT_GE(split.test.size(), 20u);
  ExpectFarApart(split, poses, options.near);
  // They are not far from all of them: a hole is not larger than it has to be.
  for (const int test : split.test) {
    double nearest = 1e9;
    for (const int training : split.training) {
      nearest = std::min(nearest, ViewGap(*poses[static_cast<size_t>(test)],
                                          *poses[static_cast<size_t>(training)],
                                          options.near));
    }
    EXPECT_LT(nearest, 4);
  }
}

TEST(SplitByHoles, IsAFunctionOfItsSeed) {
  const auto poses = Loop(300);
  const FarSplit first = SplitByHoles(poses, {.seed = 1});
  EXPECT_EQ(SplitByHoles(poses, {.seed = 1}).test, first.test);
  EXPECT_EQ(SplitByHoles(poses, {.seed = 1}).training, first.training);
  EXPECT_NE(SplitByHoles(poses, {.seed = 2}).test, first.test);
}

TEST(SplitByHoles, KeepsAllForTrainingWhereEveryFrameIsNearTheOthers) {
  const FramePoses poses(50, geometry::Rigid3{});
  const FarSplit split = SplitByHoles(poses, {});
  EXPECT_EQ(split.training.size(), 50u);
  EXPECT_THAT(split.test, IsEmpty());
}

}  // namespace
}  // namespace treeline::accuracy
