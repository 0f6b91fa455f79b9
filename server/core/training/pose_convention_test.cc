#include "server/core/training/pose_convention.h"

#include <optional>
#include <string>
#include <vector>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/training/box_room_recording.h"

namespace treeline::training {
namespace {

using ::testing::HasSubstr;

// The inside of a box, seen from a loop through it.
const std::vector<PosedDepth>& BoxFrames() {
  static const auto& frames = *[] {
    auto* made = new std::vector<PosedDepth>;
    for (const geometry::Rigid3& pose : BoxRoomPoses(40)) {
      made->push_back({*RenderBoxRoom(BoxRoomCalibration(), pose).depth, pose});
    }
    return made;
  }();
  return frames;
}

std::optional<OtherConvention> Found(const std::vector<PosedDepth>& frames) {
  return FindOtherConvention(frames, BoxRoomCalibration(), 1);
}

std::string Reading(const std::vector<PosedDepth>& frames) {
  const auto other = Found(frames);
  return other ? other->reading : "";
}

template <typename Change>
std::vector<PosedDepth> Changed(std::vector<PosedDepth> frames,
                                const Change& change) {
  for (PosedDepth& frame : frames) change(frame);
  return frames;
}

TEST(PoseConvention, WhatFitsIsLeftAlone) {
  EXPECT_FALSE(Found(BoxFrames()).has_value());
  EXPECT_FALSE(Found({}).has_value());
  EXPECT_FALSE(Found({BoxFrames()[0]}).has_value());
}

TEST(PoseConvention, TheInverseIsNamed) {
  const auto other = Found(Changed(BoxFrames(), [](PosedDepth& frame) {
    frame.world_from_sensor = frame.world_from_sensor.Inverse();
  }));
  ASSERT_TRUE(other.has_value());
  EXPECT_EQ(other->reading, "the poses were the inverse of what is read");
  EXPECT_EQ(other->remedy, "invert them");
  EXPECT_LT(other->agreement_as_read, 0.3);
  EXPECT_GT(other->agreement, 0.4);
}

TEST(PoseConvention, OtherAxesAreNamed) {
  const geometry::Rigid3 half_turn = {{.w = 0, .x = 1, .y = 0, .z = 0}, {}};
  const std::vector<PosedDepth> turned =
      Changed(BoxFrames(), [&](PosedDepth& frame) {
        frame.world_from_sensor = frame.world_from_sensor * half_turn;
      });
  EXPECT_THAT(Reading(turned), HasSubstr("axes were OpenGL's"));
  EXPECT_THAT(Reading(Changed(turned,
                              [](PosedDepth& frame) {
                                frame.world_from_sensor =
                                    frame.world_from_sensor.Inverse();
                              })),
              HasSubstr("the inverse of what is read, with OpenGL's axes"));
}

// As Unity writes them, of whom nobody has told that y points down here.
TEST(PoseConvention, LeftHandedAxesAreNamed) {
  EXPECT_THAT(Reading(Changed(BoxFrames(),
                              [](PosedDepth& frame) {
                                geometry::Rigid3& p = frame.world_from_sensor;
                                p.rotation.x = -p.rotation.x;
                                p.rotation.z = -p.rotation.z;
                                p.translation.y = -p.translation.y;
                              })),
              HasSubstr("left-handed"));
}

TEST(PoseConvention, OtherOrdersOfQuaternionsAreNamed) {
  EXPECT_THAT(Reading(Changed(BoxFrames(),
                              [](PosedDepth& frame) {
                                geometry::Rotation3& q =
                                    frame.world_from_sensor.rotation;
                                // Written w x y z, read as x y z w.
                                q = {.w = q.z, .x = q.w, .y = q.x, .z = q.y};
                              })),
              HasSubstr("qw qx qy qz, and are read as qx qy qz qw"));
  EXPECT_THAT(Reading(Changed(BoxFrames(),
                              [](PosedDepth& frame) {
                                geometry::Rotation3& q =
                                    frame.world_from_sensor.rotation;
                                q = {.w = q.x, .x = q.y, .y = q.z, .z = q.w};
                              })),
              HasSubstr("qx qy qz qw, and are read as qw qx qy qz"));
}

TEST(PoseConvention, OtherUnitsAreNamed) {
  const auto with_unit = [](double factor) {
    return Changed(BoxFrames(), [factor](PosedDepth& frame) {
      frame.depth.unit_m *= factor;
    });
  };
  EXPECT_EQ(Reading(with_unit(5)), "depth were a fifth as large");
  EXPECT_EQ(Reading(with_unit(0.2)), "depth were 5 times as large");
  EXPECT_EQ(Reading(Changed(BoxFrames(),
                            [](PosedDepth& frame) {
                              geometry::Vec3& t =
                                  frame.world_from_sensor.translation;
                              t = 1000 * t;
                            })),
            "positions were in millimetres");
}

// A camera that turns in a place, and whose positions are noise: no unit makes
// that better than no positions do.
TEST(PoseConvention, NoisyPositionsAreNoOtherUnit) {
  std::vector<PosedDepth> frames;
  base::Random random(3, 1);
  for (const geometry::Rigid3& pose : BoxRoomPoses(40)) {
    const geometry::Rigid3 turned = {pose.rotation, {}};
    frames.push_back(
        {*RenderBoxRoom(BoxRoomCalibration(), turned).depth, turned});
  }
  EXPECT_FALSE(Found(frames).has_value());
  for (PosedDepth& frame : frames) {
    frame.world_from_sensor.translation = {0.1 * random.NextGaussian(),
                                           0.1 * random.NextGaussian(),
                                           0.1 * random.NextGaussian()};
  }
  EXPECT_FALSE(Found(frames).has_value());
}

// Poses of nothing in particular fit under no reading.
TEST(PoseConvention, NonsenseIsNotExplained) {
  std::vector<PosedDepth> frames = BoxFrames();
  for (size_t i = 0; i < frames.size(); ++i) {
    const double a = static_cast<double>(i * i);
    frames[i].world_from_sensor = {
        geometry::Rotation3::FromAxisAngle({a, 2 * a, 1}), {a, 3, -a}};
  }
  EXPECT_FALSE(Found(frames).has_value());
}

}  // namespace
}  // namespace treeline::training
