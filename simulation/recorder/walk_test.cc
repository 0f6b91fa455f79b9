#include "simulation/recorder/walk.h"

#include <cmath>
#include <numbers>

#include "gtest/gtest.h"

namespace treeline::recorder {
namespace {

constexpr worlds::WalkArea kArea = {
    .center_x_m = 2.5, .center_y_m = 2, .half_x_m = 1.3, .half_y_m = 0.9};

TEST(WalkTest, StaysInItsAreaAtEyeHeight) {
  for (uint64_t seed = 0; seed < 5; ++seed) {
    const Walk walk(kArea, seed);
    for (double t = 0; t < 200; t += 0.1) {
      const geometry::Rigid3 pose = walk.WorldFromCameraAt(t);
      const double x = (pose.translation.x - 2.5) / 1.3;
      const double y = (pose.translation.y - 2) / 0.9;
      ASSERT_LE(x * x + y * y, 1 + 1e-9);
      ASSERT_GE(pose.translation.z, 1.2 - 1e-9);
      ASSERT_LE(pose.translation.z, 1.6 + 1e-9);
    }
  }
}

TEST(WalkTest, MovesAndTurnsLikeAPersonWithoutJumps) {
  const Walk walk(kArea, 1);
  geometry::Rigid3 last = walk.WorldFromCameraAt(0);
  double way_m = 0;
  for (int i = 1; i < 3000; ++i) {
    const geometry::Rigid3 pose = walk.WorldFromCameraAt(i / 30.0);
    const geometry::PoseError step = geometry::ErrorBetween(pose, last);
    ASSERT_LT(step.translation_m, 1.2 / 30);  // m/s
    ASSERT_LT(step.rotation_rad, 2.0 / 30);   // rad/s
    way_m += step.translation_m;
    last = pose;
  }
  EXPECT_GT(way_m / 100, 0.25);
  EXPECT_LT(way_m / 100, 0.7);
}

TEST(WalkTest, TheCameraIsUprightAndLooksAllAround) {
  const Walk walk(kArea, 2);
  std::array<int, 8> looks{};
  for (int i = 0; i < 1000; ++i) {
    const geometry::Rotation3 rotation =
        walk.WorldFromCameraAt(i / 30.0).rotation;
    const geometry::Vec3 forward = rotation * geometry::Vec3{0, 0, 1};
    ASSERT_LT((rotation * geometry::Vec3{0, 1, 0}).z,
              -0.7);  // y of the camera is down
    const double turn =
        std::atan2(forward.y, forward.x) / (2 * std::numbers::pi) + 0.5;
    ++looks[static_cast<size_t>(turn * 8) % 8];
  }
  for (const int count : looks) EXPECT_GT(count, 20);
}

TEST(WalkTest, RoundsDifferAndSeedsDiffer) {
  const Walk walk(kArea, 3);
  const Walk other(kArea, 4);
  EXPECT_GT(geometry::ErrorBetween(walk.WorldFromCameraAt(1),
                                   other.WorldFromCameraAt(1))
                .translation_m,
            0.01);
  // Never exactly the same view again within the usual length of a recording.
  const geometry::Rigid3 start = walk.WorldFromCameraAt(0);
  for (double t = 2; t < 60; t += 0.05) {
    const geometry::PoseError error =
        geometry::ErrorBetween(walk.WorldFromCameraAt(t), start);
    ASSERT_GT(error.translation_m + error.rotation_rad, 0.02) << t;
  }
}

}  // namespace
}  // namespace treeline::recorder
