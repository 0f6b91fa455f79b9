#include "simulation/renderer/renderer.h"

#include <cmath>
#include <utility>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "simulation/worlds/testing_world.h"

namespace treeline::renderer {
namespace {

camera::Camera MakeCamera(const char* text, int width = 160, int height = 120) {
  const auto camera = camera::Camera::Parse(text, width, height);
  EXPECT_TRUE(camera.ok()) << camera.status();
  return *camera;
}

// Looking along +x of the world, x of the camera along -y, y along -z.
geometry::Rigid3 LookingAlongX(geometry::Vec3 position_m) {
  return {geometry::Rotation3::FromMatrix(
              geometry::Mat3{{0, 0, 1, -1, 0, 0, 0, -1, 0}}),
          position_m};
}

class RendererTest : public ::testing::Test {
 protected:
  RendererTest() {
    auto renderer = Renderer::Create(worlds::TestingWorld(), 1);
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
  base::Random random(5, 0);
  std::vector<worlds::Float3> directions;
  for (int i = 0; i < 1003; ++i) {  // not a multiple of the packet
    directions.push_back({static_cast<float>(random.NextGaussian()),
                          static_cast<float>(random.NextGaussian()),
                          static_cast<float>(random.NextGaussian())});
  }
  std::vector<RayHit> hits(directions.size());
  const worlds::Float3 origin = {2, 2, 1.2f};
  renderer_->caster().CastMany(origin, directions, hits);
  for (size_t i = 0; i < hits.size(); ++i) {
    const RayHit single = renderer_->caster().Cast(origin, directions[i]);
    ASSERT_NE(hits[i].surface, RayHit::kNothing) << i;  // the room is closed
    ASSERT_EQ(hits[i].surface, single.surface) << i;
    ASSERT_NEAR(hits[i].distance, single.distance, 1e-4f * single.distance);
  }
}

TEST_F(RendererTest, DepthIsTheDistanceAlongTheAxis) {
  const camera::Camera camera = MakeCamera("PINHOLE,150,150,79.5,59.5");
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
  const camera::Camera camera =
      MakeCamera("OPENCV,120,120,80,60,-0.2,0.05,0.001,0");
  const auto samples = renderer_->RenderDepth(
      PixelRays(camera), LookingAlongX({3.0, 1.5, 1.25}), 1);
  for (const auto& [x, y] : {std::pair{0, 0}, {159, 119}, {80, 60}, {10, 90}}) {
    const camera::Pixel ray = *camera.Unproject({1.0 * x, 1.0 * y});
    const double depth_m =
        std::min({1.0, 1.5 / std::abs(ray.x), 1.25 / std::abs(ray.y)});
    EXPECT_NEAR(samples[static_cast<size_t>(160 * y + x)].depth_m, depth_m,
                1e-4);
  }
}

TEST_F(RendererTest, PixelsThatTheLensDoesNotSeeAreEmpty) {
  // This distortion folds before the corners.
  const camera::Camera camera = MakeCamera("SIMPLE_RADIAL,80,80,60,-0.5");
  const PixelRays rays(camera);
  EXPECT_EQ(rays.rays()[0], (worlds::Float3{0, 0, 0}));
  const geometry::Rigid3 pose = LookingAlongX({2, 1.5, 1.2});
  EXPECT_EQ(renderer_->RenderDepth(rays, pose, 1)[0].depth_m, 0);
  EXPECT_EQ(renderer_->RenderRadiance(rays, pose, 1)[0],
            (worlds::Float3{0, 0, 0}));
  EXPECT_GT(renderer_->RenderDepth(rays, pose, 1)[60 * 160 + 80].depth_m, 0);
}

TEST_F(RendererTest, LightFallsAsTheLampSays) {
  const PixelRays rays(MakeCamera("PINHOLE,150,150,79.5,59.5"));
  // From just below the lamp straight down.
  const geometry::Rigid3 down = {geometry::Rotation3::FromMatrix(geometry::Mat3{
                                     {1, 0, 0, 0, -1, 0, 0, 0, -1}}),
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
  const geometry::Rigid3 pose = LookingAlongX({1.5, 2.0, 1.4});
  const auto one = renderer_->RenderRadiance(rays, pose, 1);
  const auto depth_one = renderer_->RenderDepth(rays, pose, 1);
  const auto renderer = *Renderer::Create(worlds::TestingWorld(), 2);
  const auto two = renderer->RenderRadiance(rays, pose, 2);
  const auto depth_two = renderer->RenderDepth(rays, pose, 2);
  for (size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i], two[i]) << i;
    ASSERT_EQ(depth_one[i].depth_m, depth_two[i].depth_m) << i;
  }
}

// TestingWorld with a pane of glass across it at x = 3, if wanted, and one
// body: a grey post of 0.4 x 0.4 x 2 m.
worlds::World WorldWithAPost(bool has_glass) {
  worlds::World world = worlds::TestingWorld();
  if (has_glass) {
    worlds::Surface pane;
    pane.corners = {
        worlds::Float3{3, 3, 2.5f}, {3, 0, 2.5f}, {3, 0, 0}, {3, 3, 0}};
    pane.kind = worlds::SurfaceKind::kGlass;
    world.surfaces.push_back(pane);
  }
  world.surfaces[4].kind = worlds::SurfaceKind::kFloor;
  worlds::Body post;
  post.name = "post";
  worlds::WorldBuilder builder;
  builder.BeginBody();
  // Texture 0 of the world is the walls' grey.
  builder.AddBox({}, {-0.2f, -0.2f, 0}, {0.2f, 0.2f, 2}, {.sides = {}});
  builder.EndBody("post", 0.3f, 2, std::nullopt);
  world.bodies = builder.Build("", {}, {}, 1).bodies;
  return world;
}

TEST(RendererWithBodies, SeesThemLitLikeTheWallBehind) {
  const auto renderer = *Renderer::Create(WorldWithAPost(false), 2);
  const PixelRays rays(MakeCamera("PINHOLE,150,150,79.5,59.5"));
  const geometry::Rigid3 pose = LookingAlongX({1.5, 1.5, 1.2});
  const WorldSnapshot snapshot = renderer->caster().At(
      {{.body = 0, .world_from_body = {.origin = {3.8f, 1.5f, 0}}}});
  const size_t middle = 60 * 160 + 80;
  const auto depth = renderer->RenderDepth(snapshot, rays, pose, 1);
  EXPECT_NEAR(depth[middle].depth_m, 2.1, 1e-4);
  EXPECT_NEAR(renderer->RenderDepth(rays, pose, 1)[middle].depth_m, 2.5, 1e-4);
  // The same grey, facing as the wall does but 0.4 m nearer to the lamp, which
  // is 2 m from the wall and 1.2 m higher: 1.48 times the direct light, and
  // little more of the rest. The light is from a grid of half a metre.
  const float wall = renderer->RenderRadiance(rays, pose, 1)[middle].x;
  const auto seen = renderer->RenderRadiance(snapshot, rays, pose, 2);
  EXPECT_GT(seen[middle].x, 1.15f * wall);
  EXPECT_LT(seen[middle].x, 1.75f * wall);
  // The floor at its foot is darker than without it; that before the camera
  // is the same.
  const geometry::Rigid3 down = {geometry::Rotation3::FromMatrix(geometry::Mat3{
                                     {1, 0, 0, 0, -1, 0, 0, 0, -1}}),
                                 {3.3, 1.5, 1.5}};
  const auto without = renderer->RenderRadiance(rays, down, 1);
  const auto with = renderer->RenderRadiance(snapshot, rays, down, 1);
  const size_t beside = 60 * 160 + 79 + 25;  // 0.25 m towards the post
  EXPECT_LT(with[beside].x, 0.95f * without[beside].x);
  EXPECT_EQ(with[60 * 160].x, without[60 * 160].x);
}

TEST(RendererWithBodies, TruthNamesWhatIsThere) {
  const auto renderer = *Renderer::CreateUnlit(WorldWithAPost(true));
  const PixelRays rays(MakeCamera("PINHOLE,150,150,79.5,59.5"));
  const WorldSnapshot snapshot = renderer->caster().At(
      {{.body = 0, .world_from_body = {.origin = {2.8f, 1.5f, 0}}}});
  const auto truth =
      renderer->RenderTruth(snapshot, rays, LookingAlongX({1.5, 1.5, 0.8}), 2);
  const PixelTruth& post = truth[60 * 160 + 80];
  EXPECT_EQ(post.instance, 0);
  EXPECT_NEAR(post.depth_m, 1.1, 1e-5);
  EXPECT_NEAR(post.normal_in_camera.z, -1, 1e-5);
  EXPECT_FALSE(post.is_behind_glass);
  const PixelTruth& floor = truth[119 * 160 + 10];
  EXPECT_EQ(floor.instance, RayHit::kFixed);
  EXPECT_EQ(floor.kind, worlds::SurfaceKind::kFloor);
  EXPECT_NEAR(floor.normal_in_camera.y, -1, 1e-5);
  const PixelTruth& wall = truth[60 * 160 + 130];
  EXPECT_EQ(wall.surface, 1u);
  EXPECT_NEAR(wall.depth_m, 2.5, 1e-4);
  EXPECT_TRUE(wall.is_behind_glass);
}

TEST(RendererWithGlass, ShowsWhatIsBehindDimmed) {
  const auto glass = *Renderer::Create(WorldWithAPost(true), 2);
  const auto clear = *Renderer::Create(WorldWithAPost(false), 2);
  const PixelRays rays(MakeCamera("PINHOLE,150,150,79.5,59.5"));
  const geometry::Rigid3 pose = LookingAlongX({1.5, 1.5, 1.2});
  const size_t middle = 60 * 160 + 80;
  const worlds::Float3 through = glass->RenderRadiance(rays, pose, 1)[middle];
  const worlds::Float3 straight = clear->RenderRadiance(rays, pose, 1)[middle];
  // Transmitted 0.92 of a tint of 0.9 to 0.94; what is reflected comes on top,
  // and is less than a third of what this dim wall shows.
  EXPECT_GT(through.x, 0.92f * 0.899f * straight.x);
  EXPECT_LT(through.x, 1.2f * straight.x);
  EXPECT_LT(through.x, through.y);
  const auto depth = glass->RenderDepth(rays, pose, 1);
  EXPECT_NEAR(depth[middle].depth_m, 2.5, 1e-4);
  EXPECT_TRUE(depth[middle].is_behind_glass);
}

// The sun through a window at x = 4, y and z from 1 to 2, at 45 degrees: on the
// floor from x = 2 to 3.
TEST(RendererWithSun, LightsTheFloorBehindTheWindowButNotInShadow) {
  worlds::World world = worlds::TestingWorld();
  // A board in the way of half of it.
  worlds::Surface board;
  board.corners = {worlds::Float3{3.5f, 1, 2.4f},
                   {3.5f, 1.5f, 2.4f},
                   {3.5f, 1.5f, 0},
                   {3.5f, 1, 0}};
  world.surfaces.push_back(board);
  const auto without = *Renderer::Create(world, 2);
  world.sunbeams.push_back(
      {.corner = {3.995f, 2, 2},
       .edge_u = {0, -1, 0},
       .edge_v = {0, 0, -1},
       .to_sun = worlds::Normalized(worlds::Float3{1, 0, 1}),
       .radiance = {4, 3, 2}});
  const auto with = *Renderer::Create(world, 2);
  const PixelRays rays(MakeCamera("PINHOLE,150,150,79.5,59.5"));
  const float reflectance = world.textures[0].Mean().x;
  const auto gain_at = [&](double x, double y) {
    const geometry::Rigid3 down = {
        geometry::Rotation3::FromMatrix(
            geometry::Mat3{{1, 0, 0, 0, -1, 0, 0, 0, -1}}),
        {x, y, 1.2}};
    const size_t middle = 60 * 160 + 80;
    const worlds::Float3 lit = with->RenderRadiance(rays, down, 1)[middle];
    const worlds::Float3 unlit = without->RenderRadiance(rays, down, 1)[middle];
    return lit - unlit;
  };
  // By the cosine; what the walls give back comes on top, a fifth at most of
  // what a room that is half grey gathers.
  const float direct = 0.7071f * reflectance;
  const worlds::Float3 lit = gain_at(2.5, 1.75);
  EXPECT_GT(lit.x, 0.98f * 4 * direct);
  EXPECT_LT(lit.x, 1.3f * 4 * direct);
  EXPECT_LT(lit.z, 0.6f * lit.x);
  for (const auto& [x, y] : {std::pair(2.5, 1.25), std::pair(1.6, 1.75),
                             std::pair(3.3, 1.75), std::pair(2.5, 2.4)}) {
    EXPECT_LT(gain_at(x, y).x, 0.2f * lit.x) << x << ", " << y;
  }
}

TEST(UnlitRenderer, HasTheSameDepthAndSomeLight) {
  const auto lit = *Renderer::Create(worlds::TestingWorld(), 2);
  const auto unlit = *Renderer::CreateUnlit(worlds::TestingWorld());
  const PixelRays rays(MakeCamera("PINHOLE,150,150,79.5,59.5"));
  const geometry::Rigid3 pose = LookingAlongX({1.5, 2, 1.4});
  const auto one = lit->RenderDepth(rays, pose, 1);
  const auto two = unlit->RenderDepth(rays, pose, 1);
  for (size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].depth_m, two[i].depth_m);
  }
  EXPECT_GT(unlit->RenderRadiance(rays, pose, 1)[60 * 160 + 80].x, 0.01f);
}

TEST(OpenedRenderer, HasNoCeiling) {
  worlds::World world = worlds::TestingWorld();
  world.surfaces[5].kind = worlds::SurfaceKind::kCeiling;
  const auto opened = *Renderer::CreateOpened(std::move(world), 2, 1);
  const RayHit hit = opened->caster().Cast({2, 1.5f, 9}, {0, 0, -1});
  EXPECT_EQ(hit.surface, 4u);  // the floor
  EXPECT_NEAR(hit.distance, 9, 1e-4);
}

// A hall of so many texels that it is baked the quick way, with one lamp.
TEST(LargeWorlds, AreLitAsTheLampSays) {
  worlds::WorldBuilder builder;
  const worlds::Finish grey = {.texture = builder.AddTexture([] {
    return worlds::Canvas(8, 8, {0.5f, 0.5f, 0.5f});
  })};
  // Twelve floors side by side, 7.5 m each way, and a screen between the lamp
  // and the far ones.
  for (int i = 0; i < 12; ++i) {
    const float x = 7.5f * static_cast<float>(i);
    builder.AddPanel({}, {x, 7.5f, 0}, {7.5f, 0, 0}, {0, -7.5f, 0}, grey);
  }
  builder.AddPanel({}, {15, 7.5f, 4}, {0, -7.5f, 0}, {0, 0, -4}, grey);
  builder.AddLight({.corner = {3.65f, 3.65f, 3},
                    .edge_u = {0.2f, 0, 0},
                    .edge_v = {0, 0.2f, 0},
                    .radiance = {20, 20, 20}});
  const auto renderer =
      *Renderer::Create(builder.Build("hall", {90, 7.5f, 4}, {}, 1), 2);
  const PixelRays rays(MakeCamera("PINHOLE,150,150,79.5,59.5"));
  const auto below = [&](double x_m, double y_m) {
    const geometry::Rigid3 down = {
        geometry::Rotation3::FromMatrix(
            geometry::Mat3{{1, 0, 0, 0, -1, 0, 0, 0, -1}}),
        {x_m, y_m, 0.5}};
    return renderer->RenderRadiance(rays, down, 1)[60 * 160 + 80].x;
  };
  // cos^2 / distance^2 of 0.04 m^2 of radiance 20; nothing else to speak of.
  const auto direct = [](double aside_m) {
    const double squared = 9 + aside_m * aside_m;
    return 0.25 * 20 * 0.04 * 9 / (squared * squared) / 3.14159;
  };
  EXPECT_NEAR(below(3.75, 3.75), direct(0), 0.05 * direct(0));
  EXPECT_NEAR(below(3.75, 6.75), direct(3), 0.05 * direct(3));
  EXPECT_NEAR(below(12.75, 3.75), direct(9), 0.15 * direct(9));
  EXPECT_LT(below(18, 3.75), 0.02 * direct(0));  // behind the screen
}

}  // namespace
}  // namespace treeline::renderer
