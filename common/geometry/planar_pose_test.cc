#include "common/geometry/planar_pose.h"

#include <numbers>

#include "gtest/gtest.h"

namespace treeline::geometry {
namespace {

TEST(PlanarPoseTest, LeavesOutHeightAndTilt) {
  const double yaw_rad = 2.5;
  const Rigid3 tilted = {Rotation3::FromAxisAngle({0, 0, yaw_rad}) *
                             Rotation3::FromAxisAngle({0, 0.3, 0}) *
                             Rotation3::FromAxisAngle({-0.2, 0, 0}),
                         {1, 2, 3}};
  const Rigid2 planar = PlanarPose(tilted);
  EXPECT_EQ(planar.translation, (Vec2{1, 2}));
  // Rounding alone.
  EXPECT_NEAR(planar.yaw_rad, yaw_rad, 1e-12);
  EXPECT_NEAR(Yaw_rad(Rotation3::FromAxisAngle({0, 0, -std::numbers::pi / 2})),
              -std::numbers::pi / 2, 1e-12);
}

}  // namespace
}  // namespace treeline::geometry
