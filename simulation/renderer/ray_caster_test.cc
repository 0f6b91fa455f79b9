#include "simulation/renderer/ray_caster.h"

#include <cmath>
#include <numbers>

#include "gtest/gtest.h"
#include "simulation/worlds/testing_world.h"

namespace treeline::renderer {
namespace {

// TestingWorld with a pane of glass across it at x = 3, and one body: a box of
// 0.4 x 0.2 x 1 m that stands on the origin of its frame.
worlds::World WorldWithABody() {
  worlds::World world = worlds::TestingWorld();
  worlds::Surface pane;
  pane.corners = {worlds::Float3{3, 0, 2}, {3, 3, 2}, {3, 3, 0}, {3, 0, 0}};
  pane.kind = worlds::SurfaceKind::kGlass;
  world.surfaces.insert(world.surfaces.begin(), pane);

  worlds::WorldBuilder builder;
  const worlds::Finish grey = {
      .texture = builder.AddTexture([] { return worlds::Canvas(8, 8); })};
  builder.BeginBody();
  builder.AddBox({}, {-0.2f, -0.1f, 0}, {0.2f, 0.1f, 1}, {.sides = grey});
  builder.EndBody("post", 0.23f, 1, std::nullopt);
  world.bodies = builder.Build("", {}, {}, 1).bodies;
  return world;
}

TEST(RayCaster, GlassIsNotInTheWay) {
  const worlds::World world = WorldWithABody();
  const RayCaster caster = *RayCaster::Create(world);
  const worlds::Float3 from = {2, 1.5f, 1};
  const RayHit solid = caster.Cast(from, {1, 0, 0});
  EXPECT_NEAR(solid.distance, 2, 1e-5);
  EXPECT_NEAR(world.surfaces[solid.surface].corners[0].x, 4, 1e-5);
  EXPECT_TRUE(caster.IsFree(from, {3.5f, 1.5f, 1}));
  ASSERT_TRUE(caster.has_glass());
  const RayHit glass = caster.CastGlass(from, {1, 0, 0});
  EXPECT_EQ(glass.surface, 0u);
  EXPECT_NEAR(glass.distance, 1, 1e-6);
  EXPECT_EQ(caster.CastGlass(from, {-1, 0, 0}).surface, RayHit::kNothing);
}

TEST(WorldSnapshot, WithoutBodiesIsWhatNeverMoves) {
  const RayCaster caster = *RayCaster::Create(WorldWithABody());
  const RayHit hit = caster.At({}).Cast({2, 1.5f, 1}, {1, 0, 0});
  EXPECT_EQ(hit.instance, RayHit::kFixed);
  EXPECT_NEAR(hit.distance, 2, 1e-5);
}

TEST(WorldSnapshot, SeesBodiesWhereTheyAre) {
  const RayCaster caster = *RayCaster::Create(WorldWithABody());
  const float quarter = std::numbers::pi_v<float> / 2;
  const WorldSnapshot snapshot = caster.At(
      {{.body = 0, .world_from_body = {.origin = {3, 1.5f, 0}, .yaw_rad = 0}},
       {.body = 0,
        .world_from_body = {.origin = {2, 2.5f, 0}, .yaw_rad = quarter},
        .scale = {1, 2, 1}}});
  // The first one's narrow face is 0.2 m before its middle.
  const RayHit first = snapshot.Cast({2, 1.5f, 0.5f}, {1, 0, 0});
  EXPECT_EQ(first.instance, 0);
  EXPECT_NEAR(first.distance, 0.8, 1e-5);
  // The second one, turned, is 2 x 0.2 m wide along x.
  const RayHit second = snapshot.Cast({1.5f, 2.5f, 0.5f}, {1, 0, 0});
  EXPECT_EQ(second.instance, 1);
  EXPECT_NEAR(second.distance, 0.3, 1e-5);
  // Above them there is nothing but the wall.
  EXPECT_EQ(snapshot.Cast({2, 1.5f, 1.1f}, {1, 0, 0}).instance, RayHit::kFixed);
  EXPECT_FALSE(snapshot.IsFree({2, 1.5f, 0.5f}, {3.5f, 1.5f, 0.5f}));
  EXPECT_TRUE(caster.IsFree({2, 1.5f, 0.5f}, {3.5f, 1.5f, 0.5f}));
}

TEST(WorldSnapshot, ManyRaysAreAsOneByOne) {
  const RayCaster caster = *RayCaster::Create(WorldWithABody());
  const WorldSnapshot snapshot =
      caster.At({{.body = 0, .world_from_body = {.origin = {3, 1.5f, 0}}}});
  std::vector<worlds::Float3> directions;
  for (int i = 0; i < 101; ++i) {
    const float angle = 0.0622f * static_cast<float>(i);
    directions.push_back({std::cos(angle), std::sin(angle), -0.1f});
  }
  std::vector<RayHit> hits(directions.size());
  const worlds::Float3 from = {2, 1.6f, 0.8f};
  snapshot.CastMany(from, directions, hits);
  int moving = 0;
  for (size_t i = 0; i < directions.size(); ++i) {
    const RayHit one = snapshot.Cast(from, directions[i]);
    EXPECT_EQ(hits[i].surface, one.surface) << i;
    EXPECT_EQ(hits[i].instance, one.instance) << i;
    EXPECT_NEAR(hits[i].distance, one.distance, 1e-5) << i;
    moving += one.instance == 0 ? 1 : 0;
  }
  EXPECT_GT(moving, 2);
}

TEST(Motion, GoesFromKeyToKeyAndBegins) {
  const worlds::Motion motion = {
      .keys = {{.time_s = 1, .world_from_body = {{0, 0, 0}, 3}},
               {.time_s = 3, .world_from_body = {{4, 0, 0}, -3}}},
      .period_s = 5};
  EXPECT_EQ(motion.At(0.5).origin, (worlds::Float3{0, 0, 0}));
  EXPECT_NEAR(motion.At(2).origin.x, 2, 1e-6);
  // By the shorter way, over pi.
  EXPECT_NEAR(motion.At(2).yaw_rad, std::numbers::pi, 1e-5);
  // It returns from 3 to 5, and is then where it is at 0.
  EXPECT_NEAR(motion.At(4).origin.x, 2, 1e-6);
  EXPECT_NEAR(motion.At(12).origin.x, motion.At(2).origin.x, 1e-6);
  EXPECT_NEAR(motion.At(-3).origin.x, motion.At(2).origin.x, 1e-6);
  const worlds::Motion once = {.keys = motion.keys};
  EXPECT_EQ(once.At(100).origin.x, 4);
}

}  // namespace
}  // namespace treeline::renderer
