#include "common/dataset/tum.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::dataset {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr Time_ns kMs = 1'000'000;

TEST(AssociateByTimeTest, PairsTheNearestWithinTheBound) {
  const std::vector<Time_ns> a = {0, 100 * kMs, 200 * kMs};
  const std::vector<Time_ns> b = {5 * kMs, 119 * kMs, 221 * kMs};
  EXPECT_THAT(AssociateByTime(a, b, 20 * kMs), ElementsAre(0, 1, -1));
}

TEST(AssociateByTimeTest, TheBoundItselfIsTooFar) {
  const std::vector<Time_ns> a = {0};
  const std::vector<Time_ns> before = {-20 * kMs};
  const std::vector<Time_ns> after = {20 * kMs};
  EXPECT_THAT(AssociateByTime(a, before, 20 * kMs), ElementsAre(-1));
  EXPECT_THAT(AssociateByTime(a, after, 20 * kMs), ElementsAre(-1));
  EXPECT_THAT(AssociateByTime(a, after, 20 * kMs + 1), ElementsAre(0));
}

TEST(AssociateByTimeTest, APartnerBelongsToTheClosest) {
  // Both want b[0]; the second is closer, and the first takes what is left.
  const std::vector<Time_ns> a = {0, 10 * kMs};
  const std::vector<Time_ns> one = {8 * kMs};
  EXPECT_THAT(AssociateByTime(a, one, 20 * kMs), ElementsAre(-1, 0));
  const std::vector<Time_ns> two = {-15 * kMs, 8 * kMs};
  EXPECT_THAT(AssociateByTime(a, two, 20 * kMs), ElementsAre(0, 1));
}

TEST(AssociateByTimeTest, NothingToPairWith) {
  const std::vector<Time_ns> a = {0, 1};
  EXPECT_THAT(AssociateByTime(a, {}, kMs), ElementsAre(-1, -1));
  EXPECT_THAT(AssociateByTime({}, a, kMs), ElementsAre());
}

class InterpolatePoseTest : public ::testing::Test {
 protected:
  const std::vector<TimedPose> poses_ = {
      {100 * kMs, {geometry::Rotation3{}, {0, 0, 0}}},
      {140 * kMs, {geometry::Rotation3::FromAxisAngle({0, 0, 0.4}), {4, 8, 0}}},
      {300 * kMs,
       {geometry::Rotation3::FromAxisAngle({0, 0, 0.4}), {4, 8, 0}}}};
};

TEST_F(InterpolatePoseTest, IsLinearInTimeBetweenNeighbours) {
  const auto pose = InterpolatePose(poses_, 110 * kMs, 100 * kMs);
  ASSERT_TRUE(pose.has_value());
  EXPECT_NEAR(pose->translation.x, 1, 1e-12);
  EXPECT_NEAR(pose->translation.y, 2, 1e-12);
  EXPECT_NEAR(geometry::ToAxisAngle(pose->rotation).z, 0.1, 1e-12);
}

TEST_F(InterpolatePoseTest, AnEntryAtThatVeryTimeIsTakenAsItIs) {
  EXPECT_EQ(InterpolatePose(poses_, 100 * kMs, 0), poses_[0].world_from_camera);
  EXPECT_EQ(InterpolatePose(poses_, 300 * kMs, 0), poses_[2].world_from_camera);
}

TEST_F(InterpolatePoseTest, NothingOutsideTheRecordingOrInAGap) {
  EXPECT_FALSE(InterpolatePose(poses_, 99 * kMs, 100 * kMs).has_value());
  EXPECT_FALSE(InterpolatePose(poses_, 301 * kMs, 100 * kMs).has_value());
  EXPECT_FALSE(InterpolatePose(poses_, 200 * kMs, 100 * kMs).has_value());
  EXPECT_TRUE(InterpolatePose(poses_, 200 * kMs, 160 * kMs).has_value());
  EXPECT_FALSE(InterpolatePose({}, 0, kMs).has_value());
}

TEST(TumColorCameraTest, IsChosenByTheFolderName) {
  EXPECT_THAT(TumColorCamera("/d/rgbd_dataset_freiburg1_desk"),
              HasSubstr("517.3,516.5"));
  EXPECT_THAT(TumColorCamera("/d/tum-fr2-xyz/train/"), HasSubstr("520.9,521"));
  EXPECT_THAT(TumColorCamera("/d/freiburg3_office"),
              HasSubstr("PINHOLE,535.4,539.2,320.1,247.6"));
  EXPECT_EQ(TumColorCamera("/d/office"), "PINHOLE,525,525,319.5,239.5");
  // The innermost folder decides.
  EXPECT_THAT(TumColorCamera("/d/fr1/fr3-sitting"), HasSubstr("535.4"));
}

}  // namespace
}  // namespace treeline::dataset
