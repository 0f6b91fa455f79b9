// Worlds in another light.
#include "simulation/worlds/relight.h"

#include <algorithm>
#include <vector>

#include "gtest/gtest.h"
#include "simulation/worlds/world.h"

namespace treeline::worlds {
namespace {

World Cafe(std::optional<building::Lighting> lighting) {
  return *MakeWorld("cafe",
                    {.lighting = lighting, .threads = 1, .paint = false});
}

int LampsOf(const World& world) {
  std::vector<int> lamps;
  for (const AreaLight& light : world.lights) {
    if (light.source >= 0) lamps.push_back(light.source);
  }
  std::ranges::sort(lamps);
  return static_cast<int>(
      std::distance(lamps.begin(), std::unique(lamps.begin(), lamps.end())));
}

// Of the brightest light of this source.
Float3 BrightestOf(const World& world, bool is_sky) {
  Float3 most;
  for (const AreaLight& light : world.lights) {
    const bool is_asked = is_sky ? light.source == kSky : light.source >= 0;
    if (is_asked && light.radiance.x > most.x) {
      most = light.radiance;
    }
  }
  return most;
}

TEST(RelightTest, IsByDayAsBuilt) {
  const World as_built = Cafe(std::nullopt);
  const World by_day = Cafe(building::Lighting::kDay);
  ASSERT_EQ(as_built.lights.size(), by_day.lights.size());
  for (size_t i = 0; i < by_day.lights.size(); ++i) {
    EXPECT_EQ(as_built.lights[i].radiance, by_day.lights[i].radiance);
  }
  EXPECT_TRUE(by_day.sunbeams.empty());
  // 4 x 4 under the ceiling and one on the floor; four windows.
  EXPECT_EQ(LampsOf(by_day), 17);
  EXPECT_EQ(std::ranges::count(by_day.lights, kSky, &AreaLight::source), 4);
  // A world's lamps and skies can be told from its screens.
  for (const Surface& surface : by_day.surfaces) {
    EXPECT_TRUE(surface.emission.x <= 1 || surface.source != kNoLamp);
  }
}

TEST(RelightTest, TurnsLampsOffAndMakesThemWarm) {
  const World day = Cafe(building::Lighting::kDay);
  const World off = Cafe(building::Lighting::kLampsOff);
  EXPECT_EQ(LampsOf(off), 0);
  EXPECT_EQ(BrightestOf(off, true), kSkyRadiance);
  for (const Surface& surface : off.surfaces) {
    EXPECT_TRUE(surface.source < 0 || surface.emission == Float3{});
  }
  const World half = Cafe(building::Lighting::kHalfLamps);
  EXPECT_GE(LampsOf(half), 5);
  EXPECT_LE(LampsOf(half), 12);
  const World evening = Cafe(building::Lighting::kEvening);
  EXPECT_EQ(LampsOf(evening), LampsOf(day));
  const Float3 lamp = BrightestOf(evening, false);
  const Float3 lamp_by_day = BrightestOf(day, false);
  EXPECT_LT(lamp.z / lamp.x, 0.6f * lamp_by_day.z / lamp_by_day.x);
  const Float3 sky = BrightestOf(evening, true);
  EXPECT_LT(sky.x, 0.1f * kSkyRadiance.x);
  EXPECT_GT(sky.z, sky.x);
}

TEST(RelightTest, LetsTheSunInWhereWindowsFaceIt) {
  const World sunny = Cafe(building::Lighting::kSunny);
  // Two of the cafe's windows face north, one east and one south.
  ASSERT_GE(sunny.sunbeams.size(), 2u);
  for (const Sunbeam& beam : sunny.sunbeams) {
    EXPECT_NEAR(Norm(beam.to_sun), 1, 1e-5);
    EXPECT_GT(beam.to_sun.z, 0.4f);
    const Float3 inward = Cross(beam.edge_v, beam.edge_u);
    EXPECT_LT(Dot(inward, beam.to_sun), 0);
    EXPECT_EQ(beam.to_sun, sunny.sunbeams[0].to_sun);
  }
}

TEST(RelightTest, ChangesNothingButLight) {
  const World day = Cafe(building::Lighting::kDay);
  for (const absl::string_view name : building::LightingNames()) {
    const World world = Cafe(*building::ParseLighting(name));
    ASSERT_EQ(world.surfaces.size(), day.surfaces.size());
    for (size_t i = 0; i < day.surfaces.size(); ++i) {
      EXPECT_EQ(world.surfaces[i].corners, day.surfaces[i].corners);
      EXPECT_EQ(world.surfaces[i].texture, day.surfaces[i].texture);
    }
  }
  EXPECT_FALSE(building::ParseLighting("dusk").ok());
}

}  // namespace
}  // namespace treeline::worlds
