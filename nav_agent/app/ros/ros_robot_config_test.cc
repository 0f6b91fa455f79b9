#include "nav_agent/app/ros/ros_robot_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"

namespace treeline::ros_app {
namespace {

using ::testing::HasSubstr;

absl::StatusOr<RosRobotConfig> Read(const std::string& yaml) {
  const std::string path = absl::StrCat(::testing::TempDir(), "/robot_",
                                        static_cast<int>(getpid()), ".yaml");
  EXPECT_TRUE(base::WriteFileAtomically(path, yaml).ok());
  return ReadRosRobotConfig(path);
}

std::string ErrorOf(const std::string& yaml) {
  return std::string(Read(yaml).status().message());
}

TEST(RosRobotConfigTest, WhatANewRobotNeedsIsLittle) {
  const auto config = Read("domain_id: 7\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->domain.id, 7);
  EXPECT_EQ(config->scan, "scan");
  EXPECT_EQ(config->cmd_vel, "cmd_vel");
  EXPECT_EQ(config->pose, "amcl_pose");
  EXPECT_EQ(config->image, "");
  EXPECT_FALSE(config->base_from_laser.has_value());
}

TEST(RosRobotConfigTest, ServicesAreThoseOfTheRobotsRmw) {
  unsetenv("RMW_IMPLEMENTATION");
  EXPECT_EQ(Read("domain_id: 7\n")->rmw, Rmw::kFastDds);
  EXPECT_EQ(Read("rmw: rmw_cyclonedds_cpp\n")->rmw, Rmw::kCyclone);
  EXPECT_THAT(ErrorOf("rmw: cyclone\n"), HasSubstr("rmw_cyclonedds_cpp"));
  setenv("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp", 1);
  EXPECT_EQ(Read("domain_id: 7\n")->rmw, Rmw::kCyclone);
  EXPECT_EQ(Read("rmw: rmw_fastrtps_cpp\n")->rmw, Rmw::kFastDds);
  setenv("RMW_IMPLEMENTATION", "rmw_zenoh_cpp", 1);
  EXPECT_THAT(ErrorOf("domain_id: 7\n"),
              HasSubstr("rmw_zenoh_cpp, by RMW_IMPLEMENTATION"));
  unsetenv("RMW_IMPLEMENTATION");
}

TEST(RosRobotConfigTest, AllOfIt) {
  const auto config = Read(R"(
domain_id: 0
namespace: jackal
remap: ["cmd_vel:=/jackal/twist_mux/cmd_vel"]
base_frame: base_link
rear_scan: scan_rear
battery: battery_state
image: camera/color/image_raw/compressed
depth: camera/aligned_depth_to_color/image_raw
stamped_cmd_vel: true
base_from_laser: [0.12, 0, 0.33, 0]
front_m: 0.21
rear_m: 0.21
half_width_m: 0.215
wheel_track_m: 0.376
max_forward_mps: 1.5
)");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->node.name_space, "jackal");
  ASSERT_EQ(config->node.remappings.size(), 1U);
  EXPECT_EQ(config->camera_info, "camera/color/camera_info");
  EXPECT_EQ(config->battery, "battery_state");
  EXPECT_TRUE(config->is_cmd_vel_stamped);
  ASSERT_TRUE(config->base_from_laser.has_value());
  EXPECT_EQ(config->base_from_laser->translation.x, 0.12);
  EXPECT_EQ(config->robot.wheel_track_m, 0.376);
  // Within its body.
  EXPECT_LE(config->robot.caster_m, 0.21);
}

TEST(RosRobotConfigTest, WhatIsWrongIsNamed) {
  EXPECT_THAT(ErrorOf("domain_id: 1\nscna: scan\n"),
              ::testing::AllOf(HasSubstr(".yaml:2"), HasSubstr("'scan'")));
  EXPECT_THAT(ErrorOf("scan: ''\n"), HasSubstr("scan, odom and cmd_vel"));
  EXPECT_THAT(ErrorOf("rear_scan: scan\n"), HasSubstr("two lasers"));
  EXPECT_THAT(ErrorOf("depth: depth\n"), HasSubstr("image"));
  EXPECT_THAT(ErrorOf("base_frame: map\n"), HasSubstr("two frames"));
  EXPECT_THAT(ErrorOf("base_from_laser: [1, 2]\n"),
              HasSubstr("base_from_laser"));
  EXPECT_THAT(ErrorOf("remap: [a]\n"), HasSubstr("from:=to"));
  EXPECT_THAT(ErrorOf("wheel_track_m: 3\n"), HasSubstr("wheels"));
}

}  // namespace
}  // namespace treeline::ros_app
