#include "simulation/recorder/tour_walk.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gtest/gtest.h"
#include "simulation/worlds/testing_world.h"

namespace treeline::recorder {
namespace {

// A hall of 12 x 10 m with a platform of 0.4 m in its middle and a slope up to
// it from the west; the tour goes over it, and once too near a wall.
worlds::World Hall() {
  worlds::WorldBuilder builder;
  const worlds::Finish grey = {
      .texture = builder.AddTexture([] { return worlds::Canvas(8, 8); })};
  builder.AddPanel({}, {0, 10, 0}, {12, 0, 0}, {0, -10, 0}, grey);
  builder.AddPanel({}, {0, 10, 3}, {12, 0, 0}, {0, 0, -3}, grey);
  builder.AddPanel({}, {12, 0, 3}, {-12, 0, 0}, {0, 0, -3}, grey);
  builder.AddPanel({}, {0, 0, 3}, {0, 10, 0}, {0, 0, -3}, grey);
  builder.AddPanel({}, {12, 10, 3}, {0, -10, 0}, {0, 0, -3}, grey);
  builder.AddBox({}, {6, 4, 0}, {9, 6, 0.4f}, {.sides = grey});
  builder.AddQuad({},
                  {worlds::Float3{2, 6, 0.001f},
                   {6, 6, 0.4f},
                   {6, 4, 0.4f},
                   {2, 4, 0.001f}},
                  grey);
  worlds::World world = builder.Build("hall", {12, 10, 3}, {}, 1);
  world.tour = {
      {1, 5, 0}, {5, 5, 0.3f}, {8.5f, 5, 0.4f}, {8.5f, 9.85f, 0}, {1, 9, 0}};
  return world;
}

TEST(TourWalk, KeepsItsHeightItsPaceAndItsDistance) {
  const worlds::World world = Hall();
  const renderer::RayCaster caster = *renderer::RayCaster::Create(world);
  for (const uint64_t seed : {0u, 1u, 2u}) {
    const TourWalk walk = *TourWalk::Create(world, caster, seed);
    EXPECT_NEAR(walk.length_m(), 24, 2);
    double highest_m = 0;
    for (double t = 0; t < 40; t += 0.1) {
      const geometry::Vec3 eye = walk.WorldFromCameraAt(t).translation;
      const worlds::Float3 from = {static_cast<float>(eye.x),
                                   static_cast<float>(eye.y),
                                   static_cast<float>(eye.z)};
      const float height_m = caster.Cast(from, {0, 0, -1}).distance;
      // At the platform's edges the ground jumps, the camera does not.
      EXPECT_GT(height_m, 1.2 - 0.41) << t;
      EXPECT_LT(height_m, 1.6 + 0.41) << t;
      highest_m = std::max(highest_m, eye.z);
      for (int i = 0; i < 24; ++i) {
        const float angle =
            2 * std::numbers::pi_v<float> * static_cast<float>(i) / 24;
        EXPECT_GT(
            caster.Cast(from, {std::cos(angle), std::sin(angle), 0}).distance,
            0.4)
            << t;
      }
      const geometry::Vec3 next = walk.WorldFromCameraAt(t + 0.1).translation;
      // 0.8 m/s of the feet; the head bobs by up to 0.4 m/s.
      const double pace_mps = 10 * Norm(next - eye);
      EXPECT_GT(pace_mps, 0.4) << t;
      EXPECT_LT(pace_mps, 1.2) << t;
    }
    EXPECT_GT(highest_m, 0.4 + 1.2);  // it was up there
  }
}

TEST(TourWalk, LooksAroundSmoothly) {
  const worlds::World world = Hall();
  const renderer::RayCaster caster = *renderer::RayCaster::Create(world);
  const TourWalk walk = *TourWalk::Create(world, caster, 4);
  for (double t = 0; t < 60; t += 1.0 / 30) {
    const geometry::PoseError step = geometry::ErrorBetween(
        walk.WorldFromCameraAt(t + 1.0 / 30), walk.WorldFromCameraAt(t));
    ASSERT_LT(step.translation_m, 1.2 / 30) << t;
    // 120 degrees a second: nobody turns faster with a camera in hand.
    ASSERT_LT(step.rotation_rad, 0.07) << t;
  }
}

TEST(MakeCameraPath, NeedsSomewhereToWalk) {
  worlds::World world = Hall();
  world.tour.clear();
  const renderer::RayCaster caster = *renderer::RayCaster::Create(world);
  EXPECT_EQ(MakeCameraPath(world, caster, 0).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(MakeCameraPath(worlds::TestingWorld(), caster, 0).ok());
}

}  // namespace
}  // namespace treeline::recorder
