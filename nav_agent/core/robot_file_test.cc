#include "nav_agent/core/robot_file.h"

#include <cmath>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::core {
namespace {

using ::testing::HasSubstr;

TEST(RobotFile, KnowsTheThesissRobotAndTheChallenges) {
  for (const std::string& name : RobotNames()) {
    const auto robot = ReadRobot(name);
    ASSERT_TRUE(robot.ok()) << robot.status();
    EXPECT_TRUE(robot->Validate().ok()) << robot->Validate();
  }
  // The default, as it is without a file.
  EXPECT_EQ(ReadRobot("rmp100")->model.front_m, RobotModel().front_m);
  EXPECT_TRUE(ReadRobot("rmp100")->lasers.rear.has_value());
  const RobotDescription jackal = *ReadRobot("jackal");
  EXPECT_DOUBLE_EQ(jackal.model.front_m + jackal.model.rear_m, 0.508);
  EXPECT_DOUBLE_EQ(2 * jackal.model.half_width_m, 0.430);
  EXPECT_DOUBLE_EQ(jackal.model.max_forward_mps, 2);
  EXPECT_FALSE(jackal.lasers.rear.has_value());
  EXPECT_NEAR(jackal.lasers.front.AngleOf_rad(719), 2.356, 0.001);
}

TEST(RobotFile, ReadsWhatIsOtherwise) {
  const auto robot = ParseRobot(R"(
like: jackal
footprint: [[0.3, 0.2], [0.3, -0.2], [-0.2, -0.25], [-0.2, 0.25]]
max_forward_mps: 1.2
laser: {at: [0.1, 0, 0.2], field_of_view_rad: 3.14, beams: 181, range_max_m: 8}
rear_laser: {yaw_rad: 3.1416}
)",
                                "mine.yaml");
  ASSERT_TRUE(robot.ok()) << robot.status();
  EXPECT_DOUBLE_EQ(robot->model.front_m, 0.3);
  EXPECT_DOUBLE_EQ(robot->model.rear_m, 0.2);
  EXPECT_DOUBLE_EQ(robot->model.half_width_m, 0.25);
  EXPECT_DOUBLE_EQ(robot->model.max_forward_mps, 1.2);
  EXPECT_DOUBLE_EQ(robot->model.base_from_laser.translation.x, 0.1);
  EXPECT_EQ(robot->lasers.front.beams, 181);
  EXPECT_DOUBLE_EQ(robot->lasers.front.range_max_m, 8);
  EXPECT_NEAR(robot->lasers.front.angle_min_rad, -1.57, 1e-9);
  ASSERT_TRUE(robot->lasers.rear.has_value());
  // What is not said is the named robot's.
  EXPECT_DOUBLE_EQ(robot->model.wheel_radius_m, 0.098);
}

TEST(RobotFile, SaysWhatMeasurementsAreCorrectedByAndWhereTheCameraIs) {
  const auto robot = ParseRobot(
      "odometry: {left_scale: 0.99, right_scale: 1.01, laser_delay_s: 0.04}\n"
      "camera: {at: [0.1, 0.02, 1], yaw_rad: 1.5, down_rad: 0.3}\n",
      "mine.yaml");
  ASSERT_TRUE(robot.ok()) << robot.status();
  EXPECT_DOUBLE_EQ(robot->correction.left_scale, 0.99);
  EXPECT_DOUBLE_EQ(robot->correction.right_scale, 1.01);
  EXPECT_DOUBLE_EQ(robot->correction.laser_delay_s, 0.04);
  const geometry::Rigid3& camera = robot->model.base_from_camera;
  EXPECT_DOUBLE_EQ(camera.translation.y, 0.02);
  const geometry::Vec3 ahead = camera.rotation * geometry::Vec3{0, 0, 1};
  EXPECT_NEAR(std::atan2(ahead.y, ahead.x), 1.5, 1e-9);
  EXPECT_NEAR(ahead.z, -std::sin(0.3), 1e-9);
  // Its upper edge is up.
  EXPECT_NEAR((camera.rotation * geometry::Vec3{1, 0, 0}).z, 0, 1e-9);
  EXPECT_EQ(ParseRobot("like: jackal", "j")->correction, SensorCorrection());
  EXPECT_FALSE(ParseRobot("odometry: {left_scale: 3}", "a.yaml").ok());
  EXPECT_FALSE(ParseRobot("odometry: {laser_delay_s: .nan}", "a.yaml").ok());
  EXPECT_FALSE(ParseRobot("camera: {up: 1}", "a.yaml").ok());
}

TEST(RobotFile, SaysHowNoisyOdometryIs) {
  EXPECT_FALSE(ReadRobot("jackal")->noise.has_value());
  EXPECT_FALSE(ParseRobot("odometry: {left_scale: 0.99}", "a")->noise);
  const auto robot = ParseRobot(
      "odometry: {turn_from_turn: 0.04, turn_from_drive: 0.03,\n"
      "  drive_from_drive: 0.02, drive_from_turn: 0.01, left_scale: 0.99}\n",
      "a.yaml");
  ASSERT_TRUE(robot.ok()) << robot.status();
  EXPECT_EQ(robot->noise, (MeasuredOdometryNoise{0.04, 0.03, 0.02, 0.01}));
  EXPECT_DOUBLE_EQ(robot->correction.left_scale, 0.99);
  EXPECT_THAT(
      ParseRobot("like: jackal\nodometry:\n  turn_from_turn: 0.04", "a.yaml")
          .status()
          .message(),
      HasSubstr("turn_from_drive, drive_from_drive, drive_from_turn "
                "are missing"));
  for (const char* wrong : {"0", "2", "-0.1", ".nan", "little"}) {
    EXPECT_THAT(
        ParseRobot(std::string("odometry: {turn_from_turn: ") + wrong + "}",
                   "a.yaml")
            .status()
            .message(),
        HasSubstr("turn_from_turn"))
        << wrong;
  }
}

TEST(RobotFile, SaysAtWhichEndContactsAre) {
  EXPECT_EQ(ReadRobot("rmp100")->contacts, ContactEnd::kUnsaid);
  EXPECT_EQ(ParseRobot("charging_contacts: rear", "a.yaml")->contacts,
            ContactEnd::kRear);
  EXPECT_EQ(ParseRobot("charging_contacts: front", "a.yaml")->contacts,
            ContactEnd::kFront);
  EXPECT_THAT(
      ParseRobot("charging_contacts: left", "a.yaml").status().message(),
      HasSubstr("must be front or rear"));
}

TEST(RobotFile, MistakesAreNamedWithTheirLines) {
  EXPECT_THAT(ParseRobot("like: r2d2", "a.yaml").status().message(),
              HasSubstr("there is no robot 'r2d2'; there are rmp100, jackal, "
                        "turtlebot3"));
  EXPECT_THAT(
      ParseRobot("like: jackal\nmax_foward_mps: 1", "a.yaml")
          .status()
          .message(),
      HasSubstr("a.yaml:2: unknown key 'max_foward_mps'; did you mean"));
  EXPECT_THAT(ParseRobot("footprint: [[1, 2]]", "a.yaml").status().message(),
              HasSubstr("3 to 64 corners"));
  // Wheels outside of the body.
  EXPECT_THAT(ParseRobot("like: jackal\nwheel_track_m: 0.6", "a.yaml")
                  .status()
                  .message(),
              HasSubstr("stand out of a body"));
  EXPECT_THAT(ReadRobot("r2d2").status().message(), HasSubstr("no robot"));
}

}  // namespace
}  // namespace treeline::core
