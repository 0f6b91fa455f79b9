#include "server/core/training/shutter_estimator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/base/random.h"

namespace treeline::training {
namespace {

constexpr double kPixel = 1.0 / 500;

struct Scene {
  std::vector<MovingView> views;
  std::vector<SharedPoint> points;
};

// Points 1.5 to 4 m away, seen from 20 views that turn at up to `turn_rate`
// about each axis, with a pixel of noise; poses are off by 2 mrad.
Scene MakeScene(const image::RollingShutter& shutter, double turn_rate) {
  using geometry::Rotation3;
  base::Random random(7, 1);
  const auto vector = [&](double size) {
    return geometry::Vec3{random.NextUniform(-size, size),
                          random.NextUniform(-size, size),
                          random.NextUniform(-size, size)};
  };
  Scene scene;
  std::vector<geometry::Rigid3> true_poses;
  for (int i = 0; i < 20; ++i) {
    const geometry::Rigid3 pose{Rotation3::FromAxisAngle(vector(0.15)),
                                vector(0.1)};
    true_poses.push_back(pose);
    scene.views.push_back(
        {.world_from_color = {pose.rotation *
                                  Rotation3::FromAxisAngle(vector(0.002)),
                              pose.translation},
         .turn_rate_rad_s = vector(turn_rate)});
  }
  // Where a view sees a point of the world, and in which row.
  const auto see = [&](size_t i, geometry::Vec3 in_world, double& share) {
    geometry::Vec3 seen;
    for (int k = 0; k < 4; ++k) {
      const double s = shutter.offset_s + shutter.readout_s * share;
      seen = Rotation3::FromAxisAngle(-s * scene.views[i].turn_rate_rad_s) *
             (true_poses[i].Inverse() * in_world);
      share = 500 * seen.y / seen.z / 480;
    }
    return seen;
  };
  for (int n = 0; n < 2000; ++n) {
    const size_t i = static_cast<size_t>(random.NextUniform(0, 20));
    const size_t j = static_cast<size_t>(random.NextUniform(0, 20));
    if (i == j) continue;
    const double z = random.NextUniform(1.5, 4);
    const geometry::Vec3 in_world{z * random.NextUniform(-0.5, 0.5),
                                  z * random.NextUniform(-0.4, 0.4), z};
    SharedPoint point;
    point.from = static_cast<int>(i);
    point.to = static_cast<int>(j);
    point.point_in_from = see(i, in_world, point.share_in_from);
    const geometry::Vec3 in_j = see(j, in_world, point.share_in_to);
    point.ray_in_to = {in_j.x / in_j.z + kPixel * random.NextUniform(-1, 1),
                       in_j.y / in_j.z + kPixel * random.NextUniform(-1, 1)};
    scene.points.push_back(point);
  }
  return scene;
}

TEST(EstimateShutter, FindsHowFastRowsAreRead) {
  const image::RollingShutter shutter{.readout_s = 0.028, .offset_s = -0.006};
  const Scene scene = MakeScene(shutter, 1);
  const auto estimate = EstimateShutter(scene.views, scene.points, kPixel);
  ASSERT_TRUE(estimate);
  EXPECT_TRUE(IsRolling(*estimate));
  EXPECT_NEAR(estimate->shutter.readout_s, shutter.readout_s,
              4 * estimate->readout_sigma_s);
  // 2 mrad of 20 poses at 1 rad/s.
  EXPECT_NEAR(estimate->shutter.offset_s, shutter.offset_s, 0.001);
  EXPECT_LT(estimate->readout_sigma_s, 0.001);
  EXPECT_LT(estimate->median_after, 0.6 * estimate->median_before);
}

TEST(EstimateShutter, KnowsAShutterThatIsGlobal) {
  const Scene scene = MakeScene({}, 1);
  const auto estimate = EstimateShutter(scene.views, scene.points, kPixel);
  ASSERT_TRUE(estimate);
  EXPECT_FALSE(IsRolling(*estimate));
  EXPECT_NEAR(estimate->shutter.readout_s, 0, 4 * estimate->readout_sigma_s);
}

TEST(EstimateShutter, SaysNothingOfACameraThatHardlyTurns) {
  const Scene scene = MakeScene({.readout_s = 0.028}, 0.005);
  const auto estimate = EstimateShutter(scene.views, scene.points, kPixel);
  ASSERT_TRUE(estimate);
  EXPECT_FALSE(IsRolling(*estimate));
}

TEST(EstimateShutter, NeedsPoints) {
  Scene scene = MakeScene({.readout_s = 0.028}, 1);
  scene.points.resize(200);
  EXPECT_FALSE(EstimateShutter(scene.views, scene.points, kPixel));
}

}  // namespace
}  // namespace treeline::training
