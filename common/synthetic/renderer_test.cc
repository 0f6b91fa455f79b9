#include "common/synthetic/renderer.h"

#include <cmath>

#include "common/base/random.h"
#include "common/synthetic/testing_world.h"
#include "gtest/gtest.h"

namespace treeline {
namespace {

Camera MakeCamera(const char* text, int width = 160, int height = 120) {
  const auto camera = Camera::Parse(text, width, height);
  EXPECT_TRUE(camera.ok()) << camera.status();
  return *camera;
}

// Looking along +x of the world, x of the camera along -y, y along -z.
Rigid3 LookingAlongX(Vec3 position_m) {
  return {Rotation3::FromMatrix(Mat3{{0, 0, 1, -1, 0, 0, 0, -1, 0}}),
          position_m};
}

class RendererTest : public ::testing::Test {
 protected:
  RendererTest() {
    auto renderer = Renderer::Create(TestingWorld(), 1);
    EXPECT_TRUE(renderer.ok()) << renderer.status();
    renderer_ = *std::move(renderer);
  }
  std::unique_ptr<const Renderer> renderer_;
};

TEST_F(RendererTest, SingleRaysHitWhereGeometrySays) {
  const RayCaster& caster = renderer_->caster();
  const RayHit wall = caster.Cast({2, 1.5f, 1.5f}, {2, 0, 0});
  EXPECT_EQ(wall.surface, 1u);  // x = 4; its u grows towards -y
  EXPECT_NEAR(wall.distance, 1, 1e-6);
  EXPECT_NEAR(wall.u, 0.5, 1e-6);
  EXPECT_NEAR(wall.v, 0.4, 1e-6);
  const RayHit floor = caster.Cast({2, 2.5f, 2}, {0, 0, -1});
  EXPECT_EQ(floor.surface, 4u);
  EXPECT_NEAR(floor.distance, 2, 1e-6);
  const RayHit box = caster.Cast({0.5f, 2, 0.5f}, {0, -1, 0});
  EXPECT_NEAR(box.distance, 1, 1e-6);
  EXPECT_TRUE(caster.IsFree({2, 2, 1}, {3.99f, 2, 1}));
  EXPECT_FALSE(caster.IsFree({2, 0.5f, 0.5f}, {0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(caster.Cast({9, 9, 9}, {1, 0, 0}).surface, RayHit::kNothing);
}

TEST_F(RendererTest, ManyRaysHitWhatSingleOnesHit) {
  Random random(5, 0);
  std::vector<Float3> directions;
  for (int i = 0; i < 1003; ++i) {  // not a multiple of the packet
    directions.push_back({static_cast<float>(random.NextGaussian()),
                          static_cast<float>(random.NextGaussian()),
                          static_cast<float>(random.NextGaussian())});
  }
  std::vector<RayHit> hits(directions.size());
  const Float3 origin = {2, 2, 1.2f};
  renderer_->caster().CastMany(origin, directions, hits);
  for (size_t i = 0; i < hits.size(); ++i) {
    const RayHit single = renderer_->caster().Cast(origin, directions[i]);
    ASSERT_NE(hits[i].surface, RayHit::kNothing) << i;  // the room is closed
    ASSERT_EQ(hits[i].surface, single.surface) << i;
    ASSERT_NEAR(hits[i].distance, single.distance, 1e-4f * single.distance);
  }
}

TEST_F(RendererTest, DepthIsTheDistanceAlongTheAxis) {
  const Camera camera = MakeCamera("PINHOLE,150,150,79.5,59.5");
  const PixelRays rays(camera);
  const auto samples =
      renderer_->RenderDepth(rays, LookingAlongX({1.5, 1.5, 1.4}), 1);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const DepthSample& sample = samples[static_cast<size_t>(160 * y + x)];
      const double across = (x - 79.5) / 150;
      const double down = (y - 59.5) / 150;
      // The wall at x = 4 from 2.5 m, unless floor, ceiling or a side wall
      // (1.5 m away) is nearer.
      const double depth_m = std::min(
          {2.5, 1.5 / std::abs(across), down > 0 ? 1.4 / down : 1.1 / -down});
      ASSERT_NEAR(sample.depth_m, depth_m, 1e-4) << x << ", " << y;
      if (depth_m == 2.5) {
        const double length = std::sqrt(1 + across * across + down * down);
        ASSERT_NEAR(sample.incidence, 1 / length, 1e-5);
      }
    }
  }
}

TEST_F(RendererTest, DistortedCamerasSeeAlongTheirRays) {
  const Camera camera = MakeCamera("OPENCV,120,120,80,60,-0.2,0.05,0.001,0");
  const auto samples = renderer_->RenderDepth(
      PixelRays(camera), LookingAlongX({3.0, 1.5, 1.25}), 1);
  for (const auto& [x, y] : {std::pair{0, 0}, {159, 119}, {80, 60}, {10, 90}}) {
    const Pixel ray = *camera.Unproject({1.0 * x, 1.0 * y});
    const double depth_m =
        std::min({1.0, 1.5 / std::abs(ray.x), 1.25 / std::abs(ray.y)});
    EXPECT_NEAR(samples[static_cast<size_t>(160 * y + x)].depth_m, depth_m,
                1e-4);
  }
}

TEST_F(RendererTest, PixelsThatTheLensDoesNotSeeAreEmpty) {
  // This distortion folds before the corners.
  const Camera camera = MakeCamera("SIMPLE_RADIAL,80,80,60,-0.5");
  const PixelRays rays(camera);
  EXPECT_EQ(rays.rays()[0], (Float3{0, 0, 0}));
  const Rigid3 pose = LookingAlongX({2, 1.5, 1.2});
  EXPECT_EQ(renderer_->RenderDepth(rays, pose, 1)[0].depth_m, 0);
  EXPECT_EQ(renderer_->RenderRadiance(rays, pose, 1)[0], (Float3{0, 0, 0}));
  EXPECT_GT(renderer_->RenderDepth(rays, pose, 1)[60 * 160 + 80].depth_m, 0);
}

TEST_F(RendererTest, LightFallsAsTheLampSays) {
  const PixelRays rays(MakeCamera("PINHOLE,150,150,79.5,59.5"));
  // From just below the lamp straight down.
  const Rigid3 down = {
      Rotation3::FromMatrix(Mat3{{1, 0, 0, 0, -1, 0, 0, 0, -1}}),
      {2, 1.5, 2.3}};
  const auto radiance = renderer_->RenderRadiance(rays, down, 1);
  const float centre = radiance[60 * 160 + 80].x;
  // Direct light on the floor 2.4 m below 0.04 m^2 of radiance 20, times a
  // reflectance of 0.25, over pi; what walls reflect comes on top, and is less
  // than a third of all light in a room of this reflectance.
  const float direct = 0.25f * 20 * 0.04f / (2.4f * 2.4f) / 3.14159f;
  EXPECT_GT(centre, direct);
  EXPECT_LT(centre, 1.5f * direct);
  // Less farther away (the other corners see the box), and grey all over.
  EXPECT_LT(radiance[0].x, 0.95f * centre);
  EXPECT_GT(radiance[0].x, 0.5f * centre);
  EXPECT_NEAR(radiance[0].x, radiance[0].z, 1e-6);
}

TEST_F(RendererTest, ThreadsDoNotChangeThePicture) {
  const PixelRays rays(MakeCamera("PINHOLE,150,150,79.5,59.5"));
  const Rigid3 pose = LookingAlongX({1.5, 2.0, 1.4});
  const auto one = renderer_->RenderRadiance(rays, pose, 1);
  const auto depth_one = renderer_->RenderDepth(rays, pose, 1);
  const auto renderer = *Renderer::Create(TestingWorld(), 2);
  const auto two = renderer->RenderRadiance(rays, pose, 2);
  const auto depth_two = renderer->RenderDepth(rays, pose, 2);
  for (size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i], two[i]) << i;
    ASSERT_EQ(depth_one[i].depth_m, depth_two[i].depth_m) << i;
  }
}

}  // namespace
}  // namespace treeline
