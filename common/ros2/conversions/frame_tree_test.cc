#include "common/ros2/conversions/frame_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "common/ros2/conversions/geometry_values.h"

namespace treeline::conversions {
namespace {

messages::TransformStamped Edge(const std::string& parent,
                                const std::string& child,
                                const geometry::Rigid3& parent_from_child) {
  return {.header = {.stamp = {7, 0}, .frame_id = parent},
          .child_frame_id = child,
          .transform = TransformOf(parent_from_child)};
}

geometry::Rigid3 Turned(double yaw_rad, geometry::Vec3 translation) {
  return {.rotation = geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad}),
          .translation = translation};
}

TEST(FrameTreeTest, GoesUpAndDown) {
  FrameTree tree;
  tree.Add({.transforms = {Edge("map", "odom", Turned(0, {10, 0, 0})),
                           Edge("/base", "laser", Turned(0, {0.2, 0, 0.3}))}});
  tree.Add({.transforms = {Edge("odom", "base",
                                Turned(std::numbers::pi / 2, {1, 2, 0}))}});
  const auto map_from_laser = tree.Find("map", "/laser");
  ASSERT_TRUE(map_from_laser.ok()) << map_from_laser.status();
  EXPECT_NEAR(map_from_laser->translation.x, 11, 1e-12);
  EXPECT_NEAR(map_from_laser->translation.y, 2.2, 1e-12);
  EXPECT_NEAR(map_from_laser->translation.z, 0.3, 1e-12);
  const auto laser_from_map = tree.Find("laser", "map");
  ASSERT_TRUE(laser_from_map.ok());
  EXPECT_NEAR((*laser_from_map * map_from_laser->translation).x, 0, 1e-12);
  EXPECT_TRUE(tree.Find("laser", "laser").ok());
}

TEST(FrameTreeTest, WhatIsNotConnectedIsAnError) {
  FrameTree tree;
  tree.Add({.transforms = {Edge("odom", "base", {})}});
  EXPECT_EQ(tree.Find("base", "camera").status().code(),
            absl::StatusCode::kNotFound);
}

TEST(FrameTreeTest, AnErrorSaysWhatWasLeftOut) {
  FrameTree tree;
  messages::TransformStamped half = Edge("base", "laser", {});
  half.transform.rotation = {.x = 0, .y = 0, .z = 0, .w = 0.5};
  tree.Add({.transforms = {half}});
  EXPECT_THAT(std::string(tree.Find("base", "laser").status().message()),
              testing::HasSubstr("left out: base to laser: pose quaternion has "
                                 "norm 0.5, not 1"));
}

TEST(FrameTreeTest, LoopsAndNumbersThatAreNoneAreNoDanger) {
  FrameTree tree;
  messages::TransformStamped broken = Edge("a", "x", {});
  broken.transform.translation.x = std::numeric_limits<double>::quiet_NaN();
  tree.Add({.transforms = {Edge("a", "b", {}), Edge("b", "a", {}),
                           Edge("c", "c", {}), broken,
                           Edge("d", "far", Turned(0, {1e300, 0, 0}))}});
  EXPECT_FALSE(tree.Find("a", "b").ok());
  EXPECT_FALSE(tree.Find("a", "x").ok());
  EXPECT_FALSE(tree.Find("d", "far").ok());
  EXPECT_TRUE(tree.Find("c", "c").ok());
}

TEST(GeometryValuesTest, AQuaternionOfZerosIsNoRotation) {
  messages::Pose pose;
  pose.orientation = {.x = 0, .y = 0, .z = 0, .w = 0};
  const auto rigid = RigidOf(pose);
  ASSERT_TRUE(rigid.ok());
  EXPECT_EQ(rigid->rotation, geometry::Rotation3{});
  pose.orientation = {.x = 3, .y = 0, .z = 0, .w = 0};
  EXPECT_FALSE(RigidOf(pose).ok());
}

}  // namespace
}  // namespace treeline::conversions
