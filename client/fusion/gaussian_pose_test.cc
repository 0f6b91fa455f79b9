#include "client/fusion/gaussian_pose.h"

#include <cmath>
#include <limits>

#include "gtest/gtest.h"

namespace treeline::drift {
namespace {

constexpr double kExact = 1e-12;

GaussianPose At(double x, double position_variance_m2,
                double rotation_variance_rad2) {
  return {{.rotation = {}, .translation = {x, 0, 0}},
          Diagonal(position_variance_m2, rotation_variance_rad2)};
}

TEST(GaussianPoseTest, AnErrorOfRotationBecomesOneOfPositionOnTheWay) {
  // 0.01 rad about z, 3 m along x: 3 cm along y.
  const geometry::PoseCovariance moved =
      Transported(Diagonal(0, 1e-4), {3, 0, 0});
  EXPECT_NEAR(moved[0], 0, kExact);
  EXPECT_NEAR(moved[7], 9e-4, kExact);
  EXPECT_NEAR(moved[14], 9e-4, kExact);
  // y of position with z of rotation: the same sign.
  EXPECT_NEAR(moved[11], 3e-4, kExact);
  EXPECT_NEAR(moved[16], -3e-4, kExact);
}

TEST(GaussianPoseTest, TwoPosesAreOneByTheirInformation) {
  // 1 with variance 1 and 4 with variance 2: 2 with variance 2/3.
  const GaussianPose both = Fused(At(1, 1, 1), At(4, 2, 1));
  EXPECT_NEAR(both.world_from_camera.translation.x, 2, kExact);
  EXPECT_NEAR(both.covariance[0], 2.0 / 3, kExact);
  EXPECT_NEAR(both.covariance[35], 0.5, kExact);
  EXPECT_NEAR(SquaredDistance(At(1, 1, 1), At(4, 2, 1)), 3, kExact);
}

TEST(GaussianPoseTest, WhatIsCertainTwiceIsInfinitelyFarApart) {
  EXPECT_TRUE(std::isinf(SquaredDistance(At(1, 0, 0), At(4, 0, 0))));
}

TEST(GaussianPoseTest, MovedByTheDifferenceIsTheOther) {
  const geometry::Rigid3 a{geometry::Rotation3::FromAxisAngle({0.3, -1, 2}),
                           {1, 2, 3}};
  const geometry::Rigid3 b{geometry::Rotation3::FromAxisAngle({-2, 0.1, 0.5}),
                           {-4, 0, 1}};
  const geometry::PoseError error = ErrorBetween(Moved(a, Difference(a, b)), b);
  EXPECT_NEAR(error.translation_m, 0, kExact);
  EXPECT_NEAR(error.rotation_rad, 0, kExact);
}

TEST(GaussianPoseTest, SigmasAreTheLargest) {
  geometry::PoseCovariance covariance = Diagonal(1, 4);
  covariance[7] = 9;
  covariance[35] = 16;
  EXPECT_EQ(PositionSigma_m(covariance), 3);
  EXPECT_EQ(RotationSigma_rad(covariance), 4);
}

TEST(GaussianPoseTest, ACovarianceIsSymmetricAndSemidefinite) {
  EXPECT_TRUE(IsCovariance(Diagonal(1e-4, 1e-4)));
  EXPECT_TRUE(IsCovariance(Diagonal(0, 0)));
  // As large ones are rounded.
  geometry::PoseCovariance rounded = Diagonal(1e6, 1);
  rounded[1] = rounded[6] = 1e6;
  rounded[2] = 1e-6;
  EXPECT_TRUE(IsCovariance(rounded));

  geometry::PoseCovariance negative = Diagonal(1e-4, 1e-4);
  negative[0] = -1e-4;
  EXPECT_FALSE(IsCovariance(negative));
  geometry::PoseCovariance indefinite = Diagonal(1e-4, 1e-4);
  indefinite[1] = indefinite[6] = 2e-4;
  EXPECT_FALSE(IsCovariance(indefinite));
  geometry::PoseCovariance asymmetric = Diagonal(1e-4, 1e-4);
  asymmetric[1] = 5e-5;
  EXPECT_FALSE(IsCovariance(asymmetric));
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()}) {
    geometry::PoseCovariance broken = Diagonal(1e-4, 1e-4);
    broken[35] = bad;
    EXPECT_FALSE(IsCovariance(broken));
  }
}

}  // namespace
}  // namespace treeline::drift
