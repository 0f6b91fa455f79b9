#include "nav_agent/app/bridge/ros_arguments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace treeline::bridge_app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Words = std::vector<std::string>;

TEST(RosArgumentsTest, LaunchFilesNeedNoChange) {
  const auto made = WithoutRosArguments({"agent",
                                         "bridge",
                                         "--scene",
                                         "house",
                                         "--ros-args",
                                         "-r",
                                         "__node:=finder",
                                         "-r",
                                         "__ns:=/robot1",
                                         "--remap",
                                         "scan:=/front/scan",
                                         "-r",
                                         "finder:odom:=wheels",
                                         "-p",
                                         "use_sim_time:=True",
                                         "-p",
                                         "base_frame:=base_link",
                                         "--param",
                                         "rectified:=false",
                                         "-p",
                                         "map_from_world:=[-1, 2, 0, 1.5]",
                                         "-p",
                                         "scene:='true'",
                                         "--params-file",
                                         "p.yaml",
                                         "--log-level",
                                         "WARN",
                                         "--disable-rosout-logs",
                                         "--",
                                         "--server",
                                         "a:1"});
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_THAT(*made,
              ElementsAre("agent", "bridge", "--scene", "house", "--node-name",
                          "finder", "--namespace", "/robot1", "--remap",
                          "scan:=/front/scan", "--remap", "odom:=wheels",
                          "--use-sim-time=true", "--base-frame=base_link",
                          "--rectified=false", "--map-from-world=-1,2,0,1.5",
                          "--scene=true", "--params-file", "p.yaml",
                          "--log-level", "warn", "--server", "a:1"));
}

TEST(RosArgumentsTest, OthersStayAsTheyAre) {
  const Words words = {"agent", "run", "--map", "house", "--", "-r", "x"};
  EXPECT_EQ(*WithoutRosArguments(words), words);
  EXPECT_EQ(*WithoutRosArguments({"agent", "bridge", "--ros-args"}),
            (Words{"agent", "bridge"}));
}

TEST(RosArgumentsTest, WhatHasNoMeaningHereIsRefused) {
  const auto refused = [](const Words& words) {
    return std::string(WithoutRosArguments(words).status().message());
  };
  EXPECT_THAT(refused({"agent", "bridge", "--ros-args", "-r", "scan"}),
              HasSubstr("scan is not understood; -r FROM:=TO"));
  EXPECT_THAT(refused({"agent", "bridge", "--ros-args", "-r"}),
              HasSubstr("-r lacks its value"));
  EXPECT_THAT(refused({"agent", "bridge", "--ros-args", "--enclave", "/x"}),
              HasSubstr("--enclave is not understood"));
  EXPECT_THAT(
      refused({"agent", "bridge", "--ros-args", "-p", "base_frme:=base_link"}),
      HasSubstr("no parameter 'base_frme'; did you mean 'base_frame'?"));
  EXPECT_THAT(refused({"agent", "bridge", "--ros-args", "-p", "scan:={a: 1}"}),
              HasSubstr("'value' must be one value"));
  EXPECT_THAT(refused({"agent", "run", "--ros2", "r.yaml", "--ros-args", "-p",
                       "use_sim_time:=true"}),
              HasSubstr("use_sim_time stand in the file"));
}

}  // namespace
}  // namespace treeline::bridge_app
