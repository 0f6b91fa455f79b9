#include "server/core/keyframes/depth_scale.h"

#include <cmath>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {
namespace {

constexpr double kNoise_m = 0.01;

// A corner of a room before the camera: two walls and the floor, 1 to 3 m away.
// What is measured is the truth over `scale`, with noise along the ray.
class DepthScaleTest : public testing::Test {
 protected:
  SurfacePoints Corner(double scale, double noise_m = kNoise_m,
                       double offset_m = 0) {
    base::Random random(7, 0);
    SurfacePoints points;
    const auto add = [&](geometry::Vec3 point, geometry::Vec3 normal) {
      const double far = geometry::Norm(point);
      const double measured =
          far / scale + noise_m * random.NextGaussian() + offset_m;
      points.Append(point, normal, (measured / far) * point,
                    kNoise_m * kNoise_m);
    };
    for (int i = 0; i < 100; ++i) {
      const double along = random.NextUniform(-1, 1);
      const double up = random.NextUniform(-0.8, 0.8);
      add({along, up, 3}, {0, 0, -1});
      add({-1, up, 2 + along}, {1, 0, 0});
      add({along, 0.8, 2 + up}, {0, -1, 0});
    }
    points.Pad();
    return points;
  }

  // Of a camera at the origin, that looks along z.
  static PinholeView View(geometry::Vec3 position = {}) {
    return ViewOf(geometry::Rigid3{{}, -position},
                  *camera::Camera::Parse("PINHOLE,500,500,320,240", 640, 480),
                  {});
  }

  // A picture that knows position (m) and rotation (rad) as well as this,
  // before its points' errors are taken to go together.
  static PoseInformation Knows(double sigma) {
    PoseInformation information{};
    for (size_t i = 0; i < 6; ++i) {
      information[7 * i] = kCorrelatedPoints / (sigma * sigma);
    }
    return information;
  }
};

TEST_F(DepthScaleTest, IsFoundBesideTheErrorOfThePose) {
  for (const double scale : {0.92, 0.96, 1.0, 1.02, 1.07}) {
    // 1 cm off in each direction, which is what the picture knows of it.
    const auto estimate = EstimateDepthScale(
        Corner(scale), View({0.01, -0.01, 0.01}), Knows(0.01));
    ASSERT_TRUE(estimate.has_value()) << scale;
    EXPECT_NEAR(std::log(estimate->scale / scale), 0, 3 * estimate->sigma);
    EXPECT_NEAR(estimate->scale, scale, 0.004);
    EXPECT_LT(estimate->sigma, 0.01);
    EXPECT_GT(estimate->points, 250);
    EXPECT_GT(estimate->agreement, 0.97);
  }
}

// Noise of 1 cm of 300 points leaves 1 cm / (2 m sqrt(300)); errors that go
// together make that 8 times as much.
TEST_F(DepthScaleTest, IsAsSureAsPoseAndPointsAllow) {
  const auto known = EstimateDepthScale(Corner(1.05), View(), Knows(0.001));
  const auto vague = EstimateDepthScale(Corner(1.05), View(), Knows(0.1));
  ASSERT_TRUE(known && vague);
  EXPECT_NEAR(known->sigma, 0.0023, 0.001);
  EXPECT_GT(vague->sigma, 1.3 * known->sigma);
}

TEST_F(DepthScaleTest, WhatIsMeasuredElsewhereAgreesWithNoScale) {
  SurfacePoints points = Corner(1.05);
  base::Random random(8, 0);
  for (size_t i = 0; i < points.size(); ++i) {
    const float by = static_cast<float>(random.NextUniform(0.6, 1.4));
    points.measured_x[i] *= by;
    points.measured_y[i] *= by;
    points.measured_z[i] *= by;
  }
  const auto estimate = EstimateDepthScale(points, View(), Knows(0.01));
  if (estimate) {
    EXPECT_LT(estimate->agreement, 0.3);
  }
}

TEST_F(DepthScaleTest, AThirdThatIsHiddenDoesNotMoveIt) {
  SurfacePoints points = Corner(1.05);
  for (size_t i = 0; i < points.size(); i += 3) {
    points.measured_x[i] *= 0.5F;
    points.measured_y[i] *= 0.5F;
    points.measured_z[i] *= 0.5F;
  }
  const auto estimate = EstimateDepthScale(points, View(), Knows(0.01));
  ASSERT_TRUE(estimate.has_value());
  EXPECT_NEAR(estimate->scale, 1.05, 0.006);
  EXPECT_NEAR(estimate->agreement, 0.66, 0.05);
}

TEST_F(DepthScaleTest, NothingIsSaidOfFewPointsOrOfAnotherUnit) {
  EXPECT_FALSE(EstimateDepthScale({}, View(), Knows(0.01)));
  EXPECT_FALSE(DepthScaleStep({}, View(), Knows(0.01)));
  EXPECT_FALSE(EstimateDepthScale(Corner(1.2), View(), Knows(0.01)));
  EXPECT_FALSE(EstimateDepthScale(Corner(0.5), View(), Knows(0.01)));
  SurfacePoints few;
  for (int i = 0; i + 1 < kMinScalePoints; ++i) {
    few.Append({0.01 * i, 0, 2}, {0, 0, -1}, {0.01 * i, 0, 2}, 1e-4);
  }
  few.Pad();
  EXPECT_FALSE(EstimateDepthScale(few, View(), Knows(0.01)));
}

TEST_F(DepthScaleTest, AStepPointsTheWayFromAPoseThatDepthPulledAt) {
  // Such a pose is known as well as picture and surfaces say together.
  const auto of = [&](double scale) {
    const auto step = DepthScaleStep(Corner(scale), View(), Knows(0.003));
    EXPECT_TRUE(step.has_value());
    return step ? std::log(step->scale) : 0;
  };
  EXPECT_NEAR(of(1), 0, 0.001);
  EXPECT_GT(of(1.01), 0.004);
  EXPECT_LT(of(0.99), -0.004);
}

}  // namespace
}  // namespace treeline::keyframes
