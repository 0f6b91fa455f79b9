#include "nav_agent/urdf/urdf_robot.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/core/robot_file.h"

namespace treeline::urdf {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

std::string LinkWith(const std::string& name, const std::string& geometry,
                     const std::string& origin = "") {
  return absl::StrCat("<link name=\"", name, "\"><collision>", origin,
                      "<geometry>", geometry, "</geometry></collision></link>");
}

std::string Joint(const std::string& child, const std::string& xyz,
                  const std::string& rpy = "0 0 0",
                  const std::string& type = "fixed") {
  return absl::StrCat("<joint name=\"", child, "\" type=\"", type,
                      "\"><parent link=\"base_link\"/><child link=\"", child,
                      "\"/><origin xyz=\"", xyz, "\" rpy=\"", rpy,
                      "\"/></joint>");
}

// 0.6 x 0.4 m, wheels of 0.1 m radius 0.5 m apart that reach to 0.27 m on each
// side; the base is at the height of the axle.
std::string Rover(const std::string& more) {
  const std::string wheel = "<cylinder radius=\"0.1\" length=\"0.04\"/>";
  const std::string on_side = "<origin rpy=\"1.5707963267948966 0 0\"/>";
  return absl::StrCat(
      "<robot name=\"rover\">",
      LinkWith("base_link", "<box size=\"0.6 0.4 0.3\"/>",
               "<origin xyz=\"0.05 0 0.1\"/>"),
      LinkWith("left", wheel, on_side), LinkWith("right", wheel, on_side),
      Joint("left", "0 0.25 0", "0 0 0", "continuous"),
      Joint("right", "0 -0.25 0", "0 0 0", "continuous"), more, "</robot>");
}

const std::string kLaser = "<link name=\"front_laser\"/>" +
                           Joint("front_laser", "0.2 0.01 0.25", "0 0 0.5");

absl::StatusOr<UrdfRobot> Make(const std::string& text,
                               const UrdfRobotOptions& options = {}) {
  const auto urdf = ParseUrdf(text, "rover.urdf");
  if (!urdf.ok()) return urdf.status();
  return RobotOfUrdf(*urdf, options);
}

TEST(UrdfRobot, FillsARobotsFile) {
  const std::string camera =
      "<link name=\"camera_optical\"/>" +
      Joint("camera_optical", "0.3 0 0.2", "-1.8707963 0 -1.5707963");
  const auto made = Make(Rover(kLaser + camera));
  ASSERT_TRUE(made.ok()) << made.status();
  const auto robot = core::ParseRobot(made->yaml, "made.yaml");
  ASSERT_TRUE(robot.ok()) << robot.status() << made->yaml;
  const core::RobotModel& model = robot->model;
  EXPECT_NEAR(model.front_m, 0.35, 1e-4);
  EXPECT_NEAR(model.rear_m, 0.25, 1e-4);
  EXPECT_NEAR(model.half_width_m, 0.27, 1e-4);
  EXPECT_NEAR(model.wheel_track_m, 0.5, 1e-4);
  EXPECT_NEAR(model.wheel_radius_m, 0.1, 1e-4);
  // A polygon of 16 corners encloses the wheels: 2 mm lower than they are.
  EXPECT_NEAR(model.height_m, 0.352, 1e-3);
  EXPECT_NEAR(model.base_from_laser.translation.x, 0.2, 1e-4);
  EXPECT_NEAR(model.base_from_laser.translation.y, 0.01, 1e-4);
  EXPECT_NEAR(model.base_from_laser.translation.z, 0.352, 1e-3);
  const geometry::Vec3 ahead =
      model.base_from_laser.rotation * geometry::Vec3{1, 0, 0};
  EXPECT_NEAR(std::atan2(ahead.y, ahead.x), 0.5, 1e-4);
  // The camera looks ahead and 0.3 rad down.
  const geometry::Vec3 looks =
      model.base_from_camera.rotation * geometry::Vec3{0, 0, 1};
  EXPECT_NEAR(looks.x, std::cos(0.3), 1e-3);
  EXPECT_NEAR(looks.z, -std::sin(0.3), 1e-3);
  EXPECT_FALSE(robot->lasers.rear.has_value());
  EXPECT_THAT(made->notes, Contains(HasSubstr("'front_laser'")));
}

TEST(UrdfRobot, TakesTheLinksThatAreNamed) {
  const std::string two = kLaser + "<link name=\"rear_laser\"/>" +
                          Joint("rear_laser", "-0.2 0 0.2", "0 0 3.14159");
  EXPECT_THAT(Make(Rover(two)).status().message(),
              HasSubstr("several links may be the laser: front_laser, "
                        "rear_laser"));
  const auto made = Make(Rover(two), {.laser_link = "front_laser",
                                      .rear_laser_link = "rear_laser",
                                      .like = "jackal"});
  ASSERT_TRUE(made.ok()) << made.status();
  const auto robot = core::ParseRobot(made->yaml, "made.yaml");
  ASSERT_TRUE(robot.ok());
  EXPECT_NEAR(robot->model.base_from_rear_laser.translation.x, -0.2, 1e-4);
  EXPECT_EQ(robot->model.max_forward_mps, 2.0);
  EXPECT_THAT(
      Make(Rover(two), {.laser_link = "laser"}).status().message(),
      HasSubstr(
          "there is no link 'laser' for the laser; there are: base_link"));
  EXPECT_FALSE(Make(Rover(kLaser), {.base_link = "nowhere"}).ok());
  EXPECT_FALSE(Make(Rover(kLaser), {.camera_link = "nowhere"}).ok());
  EXPECT_FALSE(Make(Rover(kLaser), {.like = "nobody"}).ok());
}

TEST(UrdfRobot, RefusesLasersThatAreNotUpright) {
  const std::string turned =
      "<link name=\"laser\"/>" + Joint("laser", "0.2 0 0.2", "3.14159 0 0");
  EXPECT_THAT(Make(Rover(turned)).status().message(),
              HasSubstr("180 degrees (upside down)"));
  const std::string below =
      "<link name=\"laser\"/>" + Joint("laser", "0.2 0 -0.5");
  EXPECT_THAT(Make(Rover(below)).status().message(),
              HasSubstr("makes no robot"));
}

TEST(UrdfRobot, NeedsShapes) {
  EXPECT_THAT(Make("<robot name=\"r\"><link name=\"base_link\"/></robot>")
                  .status()
                  .message(),
              HasSubstr("no footprint"));
  const auto meshes =
      Make("<robot name=\"r\">" +
           LinkWith("base_link", "<mesh filename=\"a.stl\"/>") + "</robot>");
  EXPECT_THAT(meshes.status().message(), HasSubstr("1 are meshes"));
}

TEST(UrdfRobot, EnclosesWhatIsRound) {
  const auto urdf = ParseUrdf(
      "<robot name=\"r\">" +
          LinkWith("base_link", "<cylinder radius=\"0.2\" length=\"0.1\"/>") +
          "<link name=\"a\">" +
          "<collision><origin xyz=\"0.013 0.005 0\"/><geometry>"
          "<sphere radius=\"0.2\"/></geometry></collision></link>" +
          Joint("a", "0 0 0", "0 0 0.1") + "</robot>",
      "r");
  ASSERT_TRUE(urdf.ok()) << urdf.status();
  const std::vector<geometry::Vec2> corners = FootprintOf(*urdf, 0);
  EXPECT_LE(corners.size(), kMaxCorners);
  EXPECT_GE(corners.size(), 12);
  // All of the circle is to the left of every side, and no corner far away.
  for (size_t i = 0; i < corners.size(); ++i) {
    const geometry::Vec2 a = corners[i];
    const geometry::Vec2 along = corners[(i + 1) % corners.size()] - a;
    for (int k = 0; k < 90; ++k) {
      const geometry::Vec2 p = {0.2 * std::cos(0.07 * k),
                                0.2 * std::sin(0.07 * k)};
      EXPECT_GT(geometry::Cross(along, p - a), -1e-9);
    }
    EXPECT_LT(geometry::Norm(a), 0.225);
  }
}

}  // namespace
}  // namespace treeline::urdf
