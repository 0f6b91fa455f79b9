#include "evaluation/report/view_axes.h"

#include <vector>

#include "gtest/gtest.h"

namespace treeline::report {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

TEST(AxesOfCameras, FindsUpAndForwardOfACameraInAZUpWorld) {
  // Camera looking along world y, its y axis down along -z.
  geometry::Mat3 rotation;
  rotation(0, 0) = 1;   // camera x -> world x
  rotation(2, 1) = -1;  // camera y -> world -z
  rotation(1, 2) = 1;   // camera z -> world y
  const ViewAxes axes = AxesOfCameras(
      {geometry::Rigid3{geometry::Rotation3::FromMatrix(rotation), {5, 6, 7}}});
  EXPECT_NEAR(axes.up_in_world.z, 1, 1e-12);
  EXPECT_NEAR(axes.forward_in_world.y, 1, 1e-12);
  EXPECT_NEAR(axes.right_in_world.x, 1, 1e-12);
}

TEST(AxesOfCameras, StaysOrthonormalWhereDirectionsVanish) {
  // Looking straight down and, in the second pair, in opposite directions.
  const geometry::Rotation3 down =
      geometry::Rotation3::FromAxisAngle({90 * kDegree, 0, 0});
  const geometry::Rotation3 flipped =
      geometry::Rotation3::FromAxisAngle({180 * kDegree, 0, 0});
  for (const std::vector<geometry::Rigid3>& cameras :
       {std::vector<geometry::Rigid3>{{down, {}}},
        std::vector<geometry::Rigid3>{{{}, {}}, {flipped, {}}},
        std::vector<geometry::Rigid3>{}}) {
    const ViewAxes axes = AxesOfCameras(cameras);
    EXPECT_NEAR(geometry::Norm(axes.up_in_world), 1, 1e-12);
    EXPECT_NEAR(geometry::Norm(axes.forward_in_world), 1, 1e-12);
    EXPECT_NEAR(geometry::Dot(axes.up_in_world, axes.forward_in_world), 0,
                1e-12);
    EXPECT_NEAR(geometry::Norm(geometry::Cross(axes.right_in_world,
                                               axes.forward_in_world) -
                               axes.up_in_world),
                0, 1e-12);
  }
}

}  // namespace
}  // namespace treeline::report
