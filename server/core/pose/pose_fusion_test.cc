#include "server/core/pose/pose_fusion.h"

#include <limits>

#include "gtest/gtest.h"

namespace treeline::pose {
namespace {

PoseWithCovariance At(geometry::Vec3 position, double sigma_m,
                      double turn_rad = 0) {
  PoseWithCovariance pose;
  pose.world_from_camera = {
      geometry::Rotation3::FromAxisAngle({0, 0, turn_rad}), position};
  for (size_t i = 0; i < 6; ++i) pose.covariance[7 * i] = sigma_m * sigma_m;
  return pose;
}

TEST(PoseFusionTest, TheSurerEstimateCountsMore) {
  const auto fused = FusePoses(At({0, 0, 0}, 0.02), At({0.1, 0, 0}, 0.01, 0.1));
  ASSERT_TRUE(fused.has_value());
  EXPECT_NEAR(fused->world_from_camera.translation.x, 0.08, 1e-12);
  EXPECT_NEAR(geometry::ToAxisAngle(fused->world_from_camera.rotation).z, 0.08,
              1e-9);
  EXPECT_NEAR(fused->covariance[0], 0.02 * 0.02 / 5, 1e-12);
}

TEST(PoseFusionTest, ADirectionThatOneDoesNotKnowIsTheOthers) {
  PoseWithCovariance a = At({0, 0, 0}, 0.01);
  a.covariance[7] = 1e4;  // of y
  const auto fused = FusePoses(a, At({0.1, 0.1, 0}, 0.01));
  ASSERT_TRUE(fused.has_value());
  EXPECT_NEAR(fused->world_from_camera.translation.x, 0.05, 1e-9);
  EXPECT_NEAR(fused->world_from_camera.translation.y, 0.1, 1e-6);
}

TEST(PoseFusionTest, SingularCovariancesGiveNothing) {
  PoseWithCovariance a = At({0, 0, 0}, 0.01);
  EXPECT_FALSE(FusePoses(a, At({0, 0, 0}, 0)).has_value());
  a.covariance[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(FusePoses(a, At({0, 0, 0}, 0.01)).has_value());
}

}  // namespace
}  // namespace treeline::pose
