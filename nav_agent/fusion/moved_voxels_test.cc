#include "nav_agent/fusion/moved_voxels.h"

#include <algorithm>
#include <functional>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/fusion/octomap_builder.h"
#include "nav_agent/fusion/testing_views.h"

namespace treeline::fusion {
namespace {

camera::Camera SmallCamera() {
  return *camera::Camera::Parse("SIMPLE_PINHOLE,292.5,159.5,119.5", 320, 240);
}

// A box with its sides along the map's axes.
struct Box {
  geometry::Vec3 low;
  geometry::Vec3 high;
};

constexpr double kNothing_m = 65;

// Where a ray of this direction from `from` enters a box, in the direction's
// length.
double EnterBox(const Box& box, geometry::Vec3 from, geometry::Vec3 ray) {
  double begin = 0;
  double end = kNothing_m;
  const auto clip = [&](double at, double step, double low, double high) {
    if (step == 0) {
      if (at < low || at > high) end = -1;
      return;
    }
    const double a = (low - at) / step;
    const double b = (high - at) / step;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  };
  clip(from.x, ray.x, box.low.x, box.high.x);
  clip(from.y, ray.y, box.low.y, box.high.y);
  clip(from.z, ray.z, box.low.z, box.high.z);
  return begin < end ? begin : kNothing_m;
}

// A hall with a floor at z = 0.025 and a wall at x = 3.5, seen by a camera at
// 1.1 m that looks along x and a little down.
class MovedVoxelsTest : public testing::Test {
 protected:
  // The camera is `aside_m` to the side, and its pose is believed to be
  // `error_m` further there.
  void See(const std::vector<Box>& things, double aside_m = 0,
           double error_m = 0) {
    const geometry::Rigid3 pose = PoseAt(aside_m);
    const image::DepthImage depth = MakeDepth(camera_, [&](double x, double y) {
      const geometry::Vec3 ray = pose.rotation * geometry::Vec3{x, y, 1};
      const geometry::Vec3 from = pose.translation;
      double depth_m = EnterBox({{-9, -9, -1}, {9, 9, 0.025}}, from, ray);
      depth_m =
          std::min(depth_m, EnterBox({{3.5, -9, -1}, {4, 9, 3}}, from, ray));
      for (const Box& thing : things) {
        depth_m = std::min(depth_m, EnterBox(thing, from, ray));
      }
      return depth_m < 9 ? depth_m : 0;
    });
    const absl::Status status = builder_.InsertDepth(
        builder_.views(), depth, camera_, PoseAt(aside_m + error_m));
    ASSERT_TRUE(status.ok()) << status;
  }
  void SeeTimes(int times, const std::vector<Box>& things) {
    for (int i = 0; i < times; ++i) See(things, 0.03 * (i % 4));
  }

  // Occupied voxels in a box.
  int OccupiedIn(const Box& box) const {
    const octree::VoxelMap map = *builder_.Map();
    int count = 0;
    for (double x = box.low.x + 0.02; x < box.high.x; x += 0.05) {
      for (double y = box.low.y + 0.02; y < box.high.y; y += 0.05) {
        for (double z = box.low.z + 0.02; z < box.high.z; z += 0.05) {
          count += map.At(map.IndexOf({x, y, z})) == octree::Voxel::kOccupied;
        }
      }
    }
    return count;
  }

  OctomapBuilder builder_ = *OctomapBuilder::Make();

 private:
  static geometry::Rigid3 PoseAt(double aside_m) {
    geometry::Rigid3 pose = LevelCamera({0, aside_m, 1.1}, 0);
    pose.rotation =
        geometry::Rotation3::FromAxisAngle({0, 0.35, 0}) * pose.rotation;
    return pose;
  }
  camera::Camera camera_ = SmallCamera();
};

// On the floor, as a trolley is.
const Box kTrolley{{1.9, -0.2, 0.05}, {2.2, 0.3, 0.65}};
const Box kLeg{{2.01, 0.015, 0.05}, {2.04, 0.04, 0.6}};
const Box kFloor{{1.6, -0.4, -0.05}, {2.6, 0.5, 0.05}};

TEST_F(MovedVoxelsTest, WhatStoodForLongAndIsSeenThroughAfterwardsIsFreed) {
  SeeTimes(12, {kTrolley});
  SeeTimes(6, {});
  // Seven misses would be needed.
  ASSERT_GT(OccupiedIn(kTrolley), 20);
  const absl::StatusOr<int64_t> freed = builder_.ForgetMoved();
  ASSERT_TRUE(freed.ok()) << freed.status();
  EXPECT_GT(*freed, 20);
  EXPECT_EQ(OccupiedIn(kTrolley), 0);
}

TEST_F(MovedVoxelsTest, WhatCameLastAndWasSeenThroughBeforeIsFreed) {
  SeeTimes(8, {});
  SeeTimes(12, {kTrolley});
  ASSERT_GT(OccupiedIn(kTrolley), 20);
  ASSERT_TRUE(builder_.ForgetMoved().ok());
  EXPECT_EQ(OccupiedIn(kTrolley), 0);
}

TEST_F(MovedVoxelsTest, TheFloorUnderItStays) {
  SeeTimes(6, {});
  const int before = OccupiedIn(kFloor);
  ASSERT_GT(before, 200);
  SeeTimes(12, {kTrolley});
  SeeTimes(6, {});
  ASSERT_TRUE(builder_.ForgetMoved().ok());
  EXPECT_GE(OccupiedIn(kFloor), before);
}

TEST_F(MovedVoxelsTest, WhatStaysStays) {
  SeeTimes(12, {kTrolley, kLeg});
  const std::string before = *builder_.FormatOt();
  const absl::StatusOr<int64_t> freed = builder_.ForgetMoved();
  ASSERT_TRUE(freed.ok());
  EXPECT_EQ(*freed, 0);
  EXPECT_EQ(*builder_.FormatOt(), before);
}

// The leg is thinner than a voxel, and poses are off by more than half of one:
// each voxel of it is passed as often as it is met.
TEST_F(MovedVoxelsTest, AThinLegIsNotEatenByBeamsThatPassIt) {
  for (int i = 0; i < 24; ++i) {
    See({kLeg}, 0.05 * (i % 5), 0.03 * ((i / 2) % 3 - 1));
  }
  const Box around{{1.9, -0.1, 0.1}, {2.15, 0.15, 0.6}};
  const int before = OccupiedIn(around);
  ASSERT_GT(before, 8);
  ASSERT_TRUE(builder_.ForgetMoved().ok());
  EXPECT_EQ(OccupiedIn(around), before);
}

// A single look through is too little: a thing that one view overlooked.
TEST_F(MovedVoxelsTest, OneViewThatMissesAThingDoesNotFreeIt) {
  SeeTimes(6, {kTrolley});
  SeeTimes(1, {});
  SeeTimes(6, {kTrolley});
  const int before = OccupiedIn(kTrolley);
  ASSERT_TRUE(builder_.ForgetMoved().ok());
  EXPECT_EQ(OccupiedIn(kTrolley), before);
}

// From 4 m on cells of depth lie a voxel apart.
TEST_F(MovedVoxelsTest, FromAfarNothingIsClearedOfAThing) {
  const Box far{{3.2, -0.2, 0.4}, {3.4, 0.3, 1.2}};
  SeeTimes(12, {far});
  SeeTimes(6, {});
  const int before = OccupiedIn(far);
  ASSERT_GT(before, 10);
  ASSERT_TRUE(builder_.ForgetMoved().ok());
  EXPECT_EQ(OccupiedIn(far), before);
}

TEST_F(MovedVoxelsTest, NewPosesMakeTheMapAsIfNothingHadBeenForgotten) {
  SeeTimes(12, {kTrolley});
  SeeTimes(6, {});
  const std::string before = *builder_.FormatOt();
  ASSERT_TRUE(builder_.ForgetMoved().ok());
  ASSERT_NE(*builder_.FormatOt(), before);
  ASSERT_TRUE(builder_.SetPoses({}).ok());
  EXPECT_EQ(*builder_.FormatOt(), before);
}

TEST(MovedVoxels, OfAnEmptyMapThereAreNone) {
  OctomapBuilder builder = *OctomapBuilder::Make();
  EXPECT_EQ(builder.ForgetMoved().value_or(-1), 0);
}

}  // namespace
}  // namespace treeline::fusion
