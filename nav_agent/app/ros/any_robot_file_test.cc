#include "nav_agent/app/ros/any_robot_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "common/base/file.h"
#include "common/base/testing_folder.h"

namespace treeline::ros_app {
namespace {

using ::testing::HasSubstr;

class AnyRobotFileTest : public ::testing::Test {
 protected:
  absl::StatusOr<AnyRobotFile> Read(const std::string& yaml) {
    const std::string path = folder_.Path("robot.yaml");
    EXPECT_TRUE(base::WriteFileAtomically(path, yaml).ok());
    return ReadAnyRobotFile(path);
  }

  base::TestingFolder folder_;
};

TEST_F(AnyRobotFileTest, EachKindIsKnownByItsKeys) {
  const auto robot = Read("like: jackal\nodometry: {turn_scale: 1.1}\n");
  ASSERT_TRUE(robot.ok()) << robot.status();
  EXPECT_EQ(robot->kind, RobotFileKind::kRobot);
  EXPECT_EQ(robot->robot.correction.turn_scale, 1.1);
  EXPECT_TRUE(robot->Correction().robot.has_value());

  const auto hardware = Read(
      "laser: tcp:10.0.0.1\nbase: /dev/ttyUSB0@460800\n"
      "camera_delay_s: 0.02\nlaser_delay_s: 0.01\n");
  ASSERT_TRUE(hardware.ok()) << hardware.status();
  EXPECT_EQ(hardware->kind, RobotFileKind::kHardware);
  EXPECT_EQ(hardware->robot.correction.camera_delay_s, 0.02);
  EXPECT_EQ(hardware->robot.correction.laser_delay_s, 0.01);

  const auto ros = Read(
      "domain_id: 3\nleft_wheel_scale: 0.9\nright_wheel_scale: 0.95\n"
      "turn_scale: 1.05\nlaser_delay_s: 0.03\ncamera_delay_s: -0.02\n"
      "wheel_track_m: 0.4\nbase_from_laser: [0.1, 0, 0.3, 0]\n");
  ASSERT_TRUE(ros.ok()) << ros.status();
  EXPECT_EQ(ros->kind, RobotFileKind::kRos);
  const core::SensorCorrection expected = {.left_scale = 0.9,
                                           .right_scale = 0.95,
                                           .turn_scale = 1.05,
                                           .laser_delay_s = 0.03,
                                           .camera_delay_s = -0.02};
  EXPECT_EQ(ros->robot.correction, expected);
  EXPECT_EQ(ros->robot.model.base_from_laser.translation.x, 0.1);
  // Its recordings tell where its sensors are.
  EXPECT_FALSE(ros->Correction().robot.has_value());
  EXPECT_EQ(ros->Correction().sensors, expected);

  const auto name = ReadAnyRobotFile("turtlebot3");
  ASSERT_TRUE(name.ok()) << name.status();
  EXPECT_EQ(name->kind, RobotFileKind::kRobot);
}

TEST_F(AnyRobotFileTest, ARelocalizerTakesWhatTheFileItselfSays) {
  const auto sensors = [this](const std::string& yaml) {
    const std::string path = folder_.Path("robot.yaml");
    EXPECT_TRUE(base::WriteFileAtomically(path, yaml).ok());
    const auto read = ReadSensorsOfFile(path);
    EXPECT_TRUE(read.ok()) << read.status();
    return read.value_or(bridge_app::SensorsOfFile());
  };
  const std::string ros = "domain_id: 3\ncamera_delay_s: 0.03\n";
  // Of a camera of some robot's, /tf knows more.
  EXPECT_FALSE(sensors(ros).base_from_camera.has_value());
  EXPECT_EQ(sensors(ros).camera_delay_s, 0.03);
  const auto told =
      sensors(ros + "base_from_camera: [0.2, 0, 1.1, -0.5, 0.5, -0.5, 0.5]\n");
  ASSERT_TRUE(told.base_from_camera.has_value());
  EXPECT_EQ(told.base_from_camera->translation.z, 1.1);
  EXPECT_FALSE(sensors("like: jackal\n").base_from_camera.has_value());
  EXPECT_TRUE(sensors("like: jackal\ncamera: {at: [0.1, 0, 0.9]}\n")
                  .base_from_camera.has_value());
  const std::string hardware =
      "laser: tcp:10.0.0.1\nbase: /dev/ttyUSB0\nlaser_delay_s: 0.01\n";
  EXPECT_FALSE(sensors(hardware).base_from_camera.has_value());
  EXPECT_EQ(sensors(hardware).laser_delay_s, 0.01);
  EXPECT_EQ(
      sensors(hardware + "camera_z_m: 1.2\n").base_from_camera->translation.z,
      1.2);
  EXPECT_FALSE(ReadSensorsOfFile("/nowhere.yaml").ok());
}

TEST_F(AnyRobotFileTest, EachKindSaysHowNoisyOdometryIs) {
  const core::MeasuredOdometryNoise noise = {0.04, 0.03, 0.02, 0.01};
  const std::string flat =
      "turn_from_turn: 0.04\nturn_from_drive: 0.03\n"
      "drive_from_drive: 0.02\ndrive_from_turn: 0.01\n";
  const std::string hardware = "laser: tcp:10.0.0.1\nbase: /dev/ttyUSB0\n";
  const std::string ros = "domain_id: 3\n";
  for (const std::string& file :
       {hardware + flat, ros + flat,
        std::string("odometry: {turn_from_turn: 0.04, turn_from_drive: 0.03, "
                    "drive_from_drive: 0.02, drive_from_turn: 0.01}\n")}) {
    const auto robot = Read(file);
    ASSERT_TRUE(robot.ok()) << robot.status();
    EXPECT_EQ(robot->robot.noise, noise) << file;
  }
  for (const std::string& kind : {hardware, ros}) {
    EXPECT_FALSE(Read(kind)->robot.noise.has_value());
    EXPECT_THAT(Read(kind + "turn_from_turn: 0.04\n").status().message(),
                HasSubstr("are missing"));
    EXPECT_THAT(Read(kind + "turn_from_turn: 4\n").status().message(),
                HasSubstr("turn_from_turn"));
  }
}

TEST_F(AnyRobotFileTest, ErrorsAreThoseOfTheKind) {
  EXPECT_THAT(Read("domain_id: 3\nturn_scale: 7\n").status().message(),
              HasSubstr("turn_scale"));
  EXPECT_THAT(Read("wheels: 3\n").status().message(), HasSubstr("wheels"));
  EXPECT_FALSE(Read("a: [").ok());
  EXPECT_FALSE(Read("- 1\n").ok());
  EXPECT_FALSE(ReadAnyRobotFile("nobody").ok());
  EXPECT_FALSE(ReadAnyRobotFile("/nowhere/robot.yaml").ok());
}

}  // namespace
}  // namespace treeline::ros_app
