#include "server/core/training/pose_watch.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/training/box_room_recording.h"

namespace treeline::training {
namespace {

constexpr int kFrames = 130;

class PoseWatchTest : public testing::Test {
 protected:
  // How many frames it took to refuse the poses; 0: they were not.
  int FramesUntilRefused(geometry::Rigid3 (*meant)(const geometry::Rigid3&)) {
    PoseWatch watch("the camera", BoxRoomCalibration(), 1);
    int taken = 0;
    for (const geometry::Rigid3& pose : BoxRoomPoses(kFrames)) {
      ++taken;
      status_ = watch.Add(*RenderBoxRoom(BoxRoomCalibration(), pose).depth,
                          meant(pose));
      if (!status_.ok()) return taken;
    }
    return 0;
  }

  absl::Status status_;
};

TEST_F(PoseWatchTest, RightPosesPass) {
  EXPECT_EQ(FramesUntilRefused([](const auto& pose) { return pose; }), 0)
      << status_;
}

TEST_F(PoseWatchTest, PosesThatAreTheInverseAreRefusedOnTheWay) {
  const int taken = FramesUntilRefused(
      [](const geometry::Rigid3& pose) { return pose.Inverse(); });
  EXPECT_EQ(taken, 20);
  EXPECT_EQ(status_.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status_.message()),
              testing::AllOf(testing::HasSubstr("the camera"),
                             testing::HasSubstr("inverse")));
}

TEST_F(PoseWatchTest, DepthOfAnotherSizeSaysNothing) {
  PoseWatch watch("the camera", BoxRoomCalibration(), 1);
  const image::DepthImage other{
      .width = 4, .height = 2, .values = {1, 2, 3, 4, 5, 6, 7, 8}};
  for (int i = 0; i < 30; ++i) EXPECT_TRUE(watch.Add(other, {}).ok());
}

}  // namespace
}  // namespace treeline::training
