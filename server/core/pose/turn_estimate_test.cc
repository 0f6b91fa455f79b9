#include "server/core/pose/turn_estimate.h"

#include <gtest/gtest.h>

#include <vector>

#include "common/base/random.h"

namespace treeline::pose {
namespace {

constexpr double kPixel = 1.0 / 500;
constexpr TurnOptions kOptions{.robust_scale = 3 * kPixel,
                               .inlier_distance = 8 * kPixel,
                               .prior_sigma_rad_s = 2,
                               .min_inliers = 20};

const geometry::Rigid3 kPose{
    geometry::Rotation3::FromAxisAngle({0.1, -0.2, 0.3}), {0.4, 0.5, -0.6}};

// 150 points 1.5 to 4 m away, seen with up to a pixel of noise while the camera
// turned; a fifth are wrong.
std::vector<TimedRay> Seen(geometry::Vec3 turn_rate_rad_s, uint64_t seed) {
  base::Random random(seed, 1);
  std::vector<TimedRay> rays;
  for (int i = 0; i < 150; ++i) {
    const double z = random.NextUniform(1.5, 4);
    const geometry::Vec3 at_stamp{z * random.NextUniform(-0.6, 0.6),
                                  z * random.NextUniform(-0.45, 0.45), z};
    TimedRay ray;
    ray.point_in_world = kPose * at_stamp;
    for (int k = 0; k < 5; ++k) {
      const geometry::Vec3 p =
          geometry::Rotation3::FromAxisAngle(-ray.delay_s * turn_rate_rad_s) *
          at_stamp;
      ray.ray = {p.x / p.z, p.y / p.z};
      ray.delay_s = -0.005 + 0.03 * ray.ray.y / 0.9;
    }
    ray.ray.x += kPixel * random.NextUniform(-1, 1);
    ray.ray.y += kPixel * random.NextUniform(-1, 1);
    if (i % 5 == 0) ray.ray.x += 0.3;
    rays.push_back(ray);
  }
  return rays;
}

TEST(EstimateTurn, FindsHowTheCameraTurned) {
  const geometry::Vec3 truth{0.4, -0.6, 1.4};
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const auto estimate = EstimateTurn(Seen(truth, seed), kPose, kOptions);
    ASSERT_TRUE(estimate);
    EXPECT_GE(estimate->inliers, 118);
    // A pixel of uniform noise over 120 points, in rows 30 ms apart; about x
    // and y a turn is told from a move by depths alone.
    EXPECT_NEAR(estimate->turn_rate_rad_s.x, truth.x, 0.15);
    EXPECT_NEAR(estimate->turn_rate_rad_s.y, truth.y, 0.15);
    EXPECT_NEAR(estimate->turn_rate_rad_s.z, truth.z, 0.15);
    EXPECT_GT(estimate->sigmas, 5);
    for (size_t i = 0; i < 6; ++i) {
      EXPECT_GE(estimate->added_covariance[7 * i], 0);
    }
  }
}

TEST(EstimateTurn, SeesNoTurnWhereThereIsNone) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const auto estimate = EstimateTurn(Seen({}, seed), kPose, kOptions);
    ASSERT_TRUE(estimate);
    EXPECT_LT(estimate->sigmas, 4);
    EXPECT_LT(geometry::Norm(estimate->turn_rate_rad_s), 0.15);
  }
}

TEST(EstimateTurn, NeedsRaysThatAgree) {
  std::vector<TimedRay> rays = Seen({}, 1);
  rays.resize(20);
  EXPECT_FALSE(EstimateTurn(rays, kPose, kOptions));
}

}  // namespace
}  // namespace treeline::pose
