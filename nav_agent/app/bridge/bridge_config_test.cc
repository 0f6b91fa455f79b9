#include "nav_agent/app/bridge/bridge_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/geometry/planar_pose.h"

namespace treeline::bridge_app {
namespace {

using ::testing::HasSubstr;

BridgeConfig Config() {
  BridgeConfig config;
  config.server = "127.0.0.1:1";
  return config;
}

TEST(BridgeConfigTest, DefaultsAreGoodButForTheServer) {
  EXPECT_TRUE(Config().Validate().ok());
  EXPECT_THAT(std::string(BridgeConfig().Validate().message()),
              HasSubstr("--server"));
}

TEST(BridgeConfigTest, CameraInfoIsBesideThePictures) {
  BridgeConfig config;
  config.image = "camera/color/image_raw/compressed";
  EXPECT_EQ(config.CameraInfoTopic(), "camera/color/camera_info");
  config.image = "/image_raw";
  EXPECT_EQ(config.CameraInfoTopic(), "/camera_info");
  config.image = "image_raw";
  EXPECT_EQ(config.CameraInfoTopic(), "camera_info");
  config.camera_info = "elsewhere";
  EXPECT_EQ(config.CameraInfoTopic(), "elsewhere");
}

TEST(BridgeConfigTest, Transforms) {
  const auto flat = ParseTransform({"1", "2", "0.5", "1.5"}, "x");
  ASSERT_TRUE(flat.ok()) << flat.status();
  EXPECT_NEAR(geometry::Yaw_rad(flat->rotation), 1.5, 1e-12);
  EXPECT_EQ(flat->translation.z, 0.5);
  const auto full =
      ParseTransform({"0", "0", "1", "-0.5", "0.5", "-0.5", "0.5"}, "x");
  ASSERT_TRUE(full.ok()) << full.status();
  // An optical frame that looks ahead: z of the camera is x of the robot.
  const geometry::Vec3 ahead = full->rotation * geometry::Vec3{0, 0, 1};
  EXPECT_NEAR(ahead.x, 1, 1e-12);
  EXPECT_THAT(
      std::string(ParseTransform({"1", "2"}, "here").status().message()),
      HasSubstr("here"));
  EXPECT_FALSE(ParseTransform({"1", "2", "3", "x"}, "here").ok());
  EXPECT_THAT(
      std::string(
          ParseTransform({"0", "0", "0", "180"}, "here").status().message()),
      HasSubstr("headings are in rad"));
  EXPECT_FALSE(
      ParseTransform({"0", "0", "0", "1", "1", "1", "1"}, "here").ok());
}

TEST(BridgeConfigTest, TheDomainIsThatOfTheEnvironment) {
  BridgeConfig config;
  EXPECT_EQ(config.Domain(nullptr)->id, 0);
  EXPECT_EQ(config.Domain("")->id, 0);
  EXPECT_EQ(config.Domain("42")->id, 42);
  EXPECT_FALSE(config.Domain("x").ok());
  config.domain_id = 7;
  EXPECT_EQ(config.Domain("42")->id, 7);
}

TEST(BridgeConfigTest, BadSettingsAreNamed) {
  BridgeConfig config = Config();
  config.remap = {"scan"};
  EXPECT_THAT(std::string(config.Validate().message()), HasSubstr("from:=to"));
  config = Config();
  config.map_from_world = {"1"};
  EXPECT_THAT(std::string(config.Validate().message()),
              HasSubstr("map_from_world"));
  config = Config();
  config.odom = "";
  EXPECT_THAT(std::string(config.Validate().message()), HasSubstr("odom"));
}

TEST(BridgeConfigTest, ARobotsFileGoesBeforeTfAndSettingsBeforeIt) {
  BridgeConfig config = Config();
  EXPECT_FALSE(config.PlaceFinder()->base_from_camera.has_value());
  const SensorsOfFile sensors = {
      .base_from_camera =
          geometry::Rigid3{.rotation = {}, .translation = {0.1, 0, 1}},
      .camera_delay_s = 0.04,
      .laser_delay_s = 0.01};
  auto options = config.PlaceFinder(sensors);
  ASSERT_TRUE(options.ok()) << options.status();
  EXPECT_EQ(options->base_from_camera->translation.x, 0.1);
  EXPECT_EQ(options->camera.delay_s, 0.04);
  EXPECT_EQ(options->laser_delay_s, 0.01);
  config.base_from_camera = {"0.2", "0", "1", "0"};
  options = config.PlaceFinder(sensors);
  ASSERT_TRUE(options.ok()) << options.status();
  EXPECT_EQ(options->base_from_camera->translation.x, 0.2);
  EXPECT_EQ(options->camera.delay_s, 0.04);
}

TEST(BridgeConfigTest, WhatIsCompressedSaysSo) {
  EXPECT_TRUE(IsCompressed("a/compressed"));
  EXPECT_TRUE(IsCompressed("a/compressedDepth"));
  EXPECT_FALSE(IsCompressed("compressed_camera/image_raw"));
}

}  // namespace
}  // namespace treeline::bridge_app
