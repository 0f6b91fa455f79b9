#include "nav_agent/core/robot_model.h"

#include <cmath>
#include <limits>

#include "gtest/gtest.h"

namespace treeline::core {
namespace {

TEST(RobotModel, TheDefaultIsValid) {
  EXPECT_TRUE(RobotModel().Validate().ok());
}

TEST(RobotModel, ACameraLooksAheadAndDown) {
  const geometry::Rigid3 base_from_camera =
      RobotModel::UprightCamera({0.1, 0, 1}, 0.2);
  // One metre along the optical axis.
  const geometry::Vec3 seen = base_from_camera * geometry::Vec3{0, 0, 1};
  EXPECT_NEAR(seen.x, 0.1 + std::cos(0.2), 1e-12);
  EXPECT_NEAR(seen.y, 0, 1e-12);
  EXPECT_NEAR(seen.z, 1 - std::sin(0.2), 1e-12);
  // The picture's right is the robot's right.
  EXPECT_NEAR((base_from_camera * geometry::Vec3{1, 0, 0}).y, -1, 1e-12);
}

TEST(RobotModel, SaysWhatIsWrong) {
  const auto message = [](const RobotModel& robot) {
    return std::string(robot.Validate().message());
  };
  EXPECT_EQ(message({.max_forward_mps = -1}),
            "robot: max_forward_mps is -1; it must be positive");
  EXPECT_EQ(message({.wheel_radius_m = std::nan("")}),
            "robot: wheel_radius_m is nan; it must be positive");
  EXPECT_EQ(message({.caster_m = 0.5}),
            "robot: casters at 0.5 m stand out of a body that reaches 0.3 m "
            "from its axle");
}

}  // namespace
}  // namespace treeline::core
