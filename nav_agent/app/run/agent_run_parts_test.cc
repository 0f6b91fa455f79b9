// The parts of treeline-agent run that need no process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "nav_agent/app/hardware/robot_hardware.h"
#include "nav_agent/app/run/agent_config.h"
#include "nav_agent/app/run/agent_loop.h"

namespace treeline::run_app {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

base::MonotonicTime At(int ms) { return base::MonotonicTime(milliseconds(ms)); }

TEST(StepTimer, StepsAreDueEveryPeriodHoweverLongTheyTake) {
  StepTimer timer(milliseconds(25));
  EXPECT_EQ(timer.NextDue(At(100)), At(100));
  EXPECT_TRUE(timer.Begin(At(100)));
  EXPECT_EQ(timer.NextDue(At(110)), At(125));
  // A little late: the next one is not.
  EXPECT_TRUE(timer.Begin(At(140)));
  EXPECT_EQ(timer.NextDue(At(141)), At(150));
}

TEST(StepTimer, AStepAPeriodLateIsMissedAndNotMadeUpFor) {
  StepTimer timer(milliseconds(25));
  EXPECT_TRUE(timer.Begin(At(0)));
  EXPECT_FALSE(timer.Begin(At(60)));
  EXPECT_EQ(timer.NextDue(At(61)), At(85));
  EXPECT_TRUE(timer.Begin(At(86)));
}

TEST(StepTimer, WithoutAPeriodNothingIsLate) {
  StepTimer timer(milliseconds(0));
  EXPECT_EQ(timer.NextDue(At(5)), At(5));
  EXPECT_TRUE(timer.Begin(At(5)));
  EXPECT_EQ(timer.NextDue(At(900)), At(900));
  EXPECT_TRUE(timer.Begin(At(900)));
}

TEST(AgentConfig, SaysWhatDoesNotFit) {
  AgentConfig config;
  EXPECT_THAT(config.Validate().message(),
              HasSubstr("one of --simulate WORLD"));
  config.simulate = "cafe";
  EXPECT_TRUE(config.Validate().ok());
  config.hardware = "robot.yaml";
  EXPECT_THAT(config.Validate().message(),
              HasSubstr("one of --simulate WORLD"));
  config.simulate.clear();
  EXPECT_THAT(config.Validate().message(), HasSubstr("--map"));
  config.hardware.clear();
  config.ros2 = "robot.yaml";
  EXPECT_THAT(config.Validate().message(), HasSubstr("--map"));
  config.map = "house";
  EXPECT_TRUE(config.Validate().ok());
  config.hardware = "robot.yaml";
  EXPECT_THAT(config.Validate().message(), HasSubstr("--ros2 FILE"));
  config.ros2.clear();
  config.map = "house";
  EXPECT_TRUE(config.Validate().ok());
  config.speed = 2;
  EXPECT_THAT(config.Validate().message(), HasSubstr("--speed"));
  config.speed = 1;
  config.start_at = {"1", "2", "3"};
  config.find_yourself = true;
  EXPECT_THAT(config.Validate().message(), HasSubstr("--find-yourself"));
  config.find_yourself = false;
  config.zone_masks = "masks.yaml";
  EXPECT_TRUE(config.Validate().ok());
  config.by_sight = true;
  EXPECT_THAT(config.Validate().message(), HasSubstr("--zone-masks"));
}

TEST(AgentConfig, ReadsPoses) {
  const auto pose = ParseRequestedPose({"1", "-2.5", "0.5", "1"}, "--goal");
  ASSERT_TRUE(pose.ok() && pose->has_value());
  EXPECT_EQ((*pose)->y_m, -2.5);
  EXPECT_EQ((*pose)->level, 1);
  EXPECT_FALSE(ParseRequestedPose({}, "--goal")->has_value());
  for (const auto& bad :
       std::vector<std::vector<std::string>>{{"1", "2"},
                                             {"1", "2", "x"},
                                             {"1", "2", "nan"},
                                             {"1", "2", "90"},
                                             {"1", "2", "-180"},
                                             {"1", "2", "3", "0.5"},
                                             {"1", "2", "3", "4", "5"}}) {
    EXPECT_THAT(ParseRequestedPose(bad, "--goal").status().message(),
                HasSubstr("--goal"));
  }
}

class HardwareConfigTest : public testing::Test {
 protected:
  absl::StatusOr<hardware::HardwareConfig> Read(const std::string& text) const {
    const std::string path = testing::TempDir() + "/hardware_config.yaml";
    EXPECT_TRUE(base::WriteFileAtomically(path, text).ok());
    return hardware::ReadHardwareConfig(path);
  }
};

TEST_F(HardwareConfigTest, ReadsAddressesAndMeasures) {
  const auto config =
      Read("laser: tcp:10.0.0.2\nbase: /dev/ttyUSB0\nlaser_x_m: 0.3\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->laser, "tcp:10.0.0.2");
  EXPECT_EQ(config->camera, "none");
  EXPECT_EQ(config->robot.base_from_laser.translation.x, 0.3);
  // What is not said is the default robot's.
  EXPECT_EQ(config->robot.front_m, core::RobotModel().front_m);
}

TEST_F(HardwareConfigTest, ARearLaserIsAnotherOneThatLooksBack) {
  const auto config = Read(
      "laser: tcp:10.0.0.2\nrear_laser: tcp:10.0.0.3\nbase: /dev/ttyUSB0\n"
      "rear_laser_x_m: -0.25\nrear_laser_yaw_rad: 3.0\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->rear_laser, "tcp:10.0.0.3");
  const geometry::Rigid3& pose = config->robot.base_from_rear_laser;
  EXPECT_EQ(pose.translation.x, -0.25);
  const geometry::Vec3 ahead = pose.rotation * geometry::Vec3{1, 0, 0};
  EXPECT_NEAR(std::atan2(ahead.y, ahead.x), 3.0, 1e-9);
  EXPECT_THAT(Read("laser: tcp:10.0.0.2\nrear_laser: tcp:10.0.0.2\n"
                   "base: /dev/ttyUSB0\n")
                  .status()
                  .message(),
              HasSubstr("they are two"));
  EXPECT_THAT(Read("laser: tcp:10.0.0.2\nrear_laser: 'tcp:'\n"
                   "base: /dev/ttyUSB0\n")
                  .status()
                  .message(),
              HasSubstr("hardware_config.yaml"));
}

TEST_F(HardwareConfigTest, NamesFileLineAndKey) {
  EXPECT_THAT(Read("laser: a\nbase: /dev/b\nlazer_x_m: 1\n").status().message(),
              HasSubstr("hardware_config.yaml:3"));
  EXPECT_THAT(Read("base: /dev/b\n").status().message(), HasSubstr("laser"));
  EXPECT_THAT(Read("laser: 'tcp:'\nbase: /dev/b\n").status().message(),
              HasSubstr("hardware_config.yaml"));
  EXPECT_THAT(
      Read("laser: /dev/a\nbase: /dev/b\nfront_m: 99\n").status().message(),
      HasSubstr("front_m"));
}

}  // namespace
}  // namespace treeline::run_app
