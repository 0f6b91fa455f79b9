#include <algorithm>
#include <cmath>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "simulation/recorder/walk.h"
#include "simulation/renderer/renderer.h"
#include "simulation/worlds/world.h"

namespace treeline {
namespace {

using ::testing::HasSubstr;

TEST(RoomTest, UnknownWorldsAreNamed) {
  for (const char* name : {"", "Room", "room:", "room:-1", "room:1.5", "x"}) {
    const auto world = worlds::MakeWorld(name, {.threads = 1});
    EXPECT_EQ(world.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(world.status().message(),
                HasSubstr("'" + std::string(name) + "'"));
  }
}

// One test, because painting a room takes seconds and each test is a process
// of its own.
TEST(RoomTest, IsFurnishedWithinItsWallsAndLeavesTheWalkFree) {
  const auto world = worlds::MakeWorld("room", {.threads = 2});
  ASSERT_TRUE(world.ok()) << world.status();
  EXPECT_EQ(world->name, "room");
  EXPECT_GT(world->surfaces.size(), 1000u);
  EXPECT_GT(world->textures.size(), 50u);
  EXPECT_GE(world->lights.size(), 3u);
  for (const worlds::Surface& surface : world->surfaces) {
    ASSERT_GE(surface.texture, 0);
    ASSERT_LT(static_cast<size_t>(surface.texture), world->textures.size());
    const worlds::Float3 normal = surface.Normal();
    for (const worlds::Float3& corner : surface.corners) {
      // Planar to a tenth of a millimetre, and inside the walls.
      ASSERT_LT(std::abs(Dot(normal, corner - surface.corners[0])), 1e-4f);
      ASSERT_GT(corner.x, -0.01f);
      ASSERT_GT(corner.y, -0.01f);
      ASSERT_GT(corner.z, -0.01f);
      ASSERT_LT(corner.x, world->size_m.x + 0.01f);
      ASSERT_LT(corner.y, world->size_m.y + 0.01f);
      ASSERT_LT(corner.z, world->size_m.z + 0.01f);
    }
  }

  // No walk bumps into anything: 25 cm are free all around.
  const auto caster = renderer::RayCaster::Create(*world);
  ASSERT_TRUE(caster.ok()) << caster.status();
  for (uint64_t seed = 0; seed < 3; ++seed) {
    const recorder::Walk walk(world->walk_area, seed);
    for (double t = 0; t < 60; t += 0.25) {
      const geometry::Vec3 at = walk.WorldFromCameraAt(t).translation;
      const worlds::Float3 eye = {static_cast<float>(at.x),
                                  static_cast<float>(at.y),
                                  static_cast<float>(at.z)};
      for (int i = 0; i < 64; ++i) {
        const float turn = 6.2831853f * static_cast<float>(i % 16) / 16;
        const float rise = 0.6f * static_cast<float>(i / 16) - 0.9f;
        const renderer::RayHit hit = caster->Cast(
            eye,
            Normalized(worlds::Float3{std::cos(turn), std::sin(turn), rise}));
        ASSERT_NE(hit.surface, renderer::RayHit::kNothing);
        ASSERT_GT(hit.distance, 0.25f) << "seed " << seed << " at " << t;
      }
    }
  }
}

TEST(RoomTest, TheSeedDecides) {
  const auto first = worlds::MakeWorld("room:11", {.threads = 2});
  const auto second = worlds::MakeWorld("room:12", {.threads = 2});
  ASSERT_TRUE(first.ok()) << first.status();
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_FALSE(first->size_m == second->size_m);
  EXPECT_NE(first->surfaces.size(), second->surfaces.size());
}

}  // namespace
}  // namespace treeline
