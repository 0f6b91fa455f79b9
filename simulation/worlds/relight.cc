#include "simulation/worlds/relight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "common/base/random.h"

namespace treeline::worlds {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
// Of the sun: above the horizon, and beside the way that most of the window
// area faces.
constexpr float kSunElevation_rad = 32 * kPi / 180;
constexpr float kSunAside_rad = 35 * kPi / 180;
// Windows that the sun sees at less than this cosine let no beam in: their
// frames are deeper than that.
constexpr float kGrazing = 0.15f;
// Before a window's view: what lies between two of its bars.
constexpr float kPortal_m = 0.003f;
constexpr uint64_t kLampStream = 0x1a;

// Colours of light are relative to the camera's white, which is between
// daylight's and that of the lamps by day.
struct Look {
  // Factors on the light of windows, and on the brightness of their view.
  Float3 sky{1, 1, 1};
  Float3 view{1, 1, 1};
  // What the view reflects of the light inside. A pane before the dark shows
  // little of it; by day its view is a picture like another.
  float view_reflection = 1;
  // Of lamps that are on, and which share of them is.
  Float3 lamps{1, 1, 1};
  double lit_share = 1;
  // A white surface that faces it.
  Float3 sun{};
};

// By building::Lighting. Ratios of brightness are smaller than real ones, as
// if panes were tinted: a room with its lamps on has 300 lx, a bright sky
// 10,000 lx and the sun 80,000 lx.
constexpr std::array<Look, 6> kLooks = {{
    {},
    // A clear sky is bluer than clouds, the sun warmer (5500 K).
    {.sky = {2.1f, 2.3f, 2.7f},
     .view = {2.4f, 2.6f, 3.0f},
     .sun = {9.0f, 8.2f, 6.6f}},
    {.lit_share = 0},
    // Lamps of 2700 K in place of by day's 4000 K; the sky of dusk.
    {.sky = {0.03f, 0.045f, 0.09f},
     .view = {0.05f, 0.075f, 0.15f},
     .view_reflection = 0.12f,
     .lamps = {0.80f, 0.60f, 0.34f}},
    {.sky = {0.003f, 0.003f, 0.004f},
     .view = {0.004f, 0.004f, 0.006f},
     .view_reflection = 0.04f,
     .lamps = {0.80f, 0.60f, 0.34f},
     .lit_share = 0.5},
    // Street lamps (sodium, 2100 K).
    {.sky = {0.080f, 0.056f, 0.028f},
     .view = {0.012f, 0.009f, 0.005f},
     .view_reflection = 0.04f,
     .lit_share = 0},
}};

bool IsLit(int lamp, double share) {
  return base::Random(kLampStream, static_cast<uint64_t>(lamp)).NextUnit() <
         share;
}

// On what comes from `source`; 1 for what is neither lamp nor sky.
Float3 FactorOn(int source, const Look& look, Float3 sky) {
  if (source == kSky) return sky;
  if (source == kNoLamp) return {1, 1, 1};
  return IsLit(source, look.lit_share) ? look.lamps : Float3{};
}

Float3 OutwardOf(const AreaLight& window) {
  return -1 * Normalized(window.AreaNormal());
}

// Towards the sun. Of eight directions, the one that most window area faces,
// and a little aside.
Float3 ToSun(const World& world) {
  constexpr size_t kDirections = 8;
  constexpr float kStep_rad = 2 * kPi / kDirections;
  std::array<float, kDirections> area_m2{};
  for (const AreaLight& light : world.lights) {
    if (light.source != kSky) continue;
    const Float3 out = OutwardOf(light);
    const long step = std::lround(std::atan2(out.y, out.x) / kStep_rad);
    area_m2[static_cast<size_t>(step + kDirections) % kDirections] +=
        Norm(light.AreaNormal());
  }
  const auto most = std::max_element(area_m2.begin(), area_m2.end());
  const float azimuth =
      kStep_rad * static_cast<float>(most - area_m2.begin()) + kSunAside_rad;
  return {std::cos(kSunElevation_rad) * std::cos(azimuth),
          std::cos(kSunElevation_rad) * std::sin(azimuth),
          std::sin(kSunElevation_rad)};
}

void AddSunbeams(Float3 radiance, World& world) {
  const Float3 to_sun = ToSun(world);
  for (const AreaLight& light : world.lights) {
    if (light.source != kSky) continue;
    const Float3 out = OutwardOf(light);
    if (Dot(out, to_sun) < kGrazing) continue;
    world.sunbeams.push_back(
        {.corner = light.corner + (kSkyBeforeView_m - kPortal_m) * out,
         .edge_u = light.edge_u,
         .edge_v = light.edge_v,
         .to_sun = to_sun,
         .radiance = radiance});
  }
}

// Screens, which by day nobody sees the light of.
void AddScreenLights(World& world) {
  constexpr float kLift_m = 0.01f;
  for (const Surface& surface : world.surfaces) {
    if (surface.source != kNoLamp || surface.emission == Float3{}) continue;
    const Texture& picture =
        world.textures[static_cast<size_t>(surface.texture)];
    world.lights.push_back(
        {.corner = surface.corners[0] + kLift_m * surface.Normal(),
         .edge_u = surface.corners[1] - surface.corners[0],
         .edge_v = surface.corners[3] - surface.corners[0],
         .radiance = surface.emission * picture.Mean()});
  }
}

}  // namespace

void Relight(building::Lighting lighting, World& world) {
  world.lighting = lighting;
  if (lighting == building::Lighting::kDay) return;
  const Look& look = kLooks[static_cast<size_t>(lighting)];
  if (!(look.sun == Float3{})) AddSunbeams(look.sun, world);
  for (AreaLight& light : world.lights) {
    light.radiance = FactorOn(light.source, look, look.sky) * light.radiance;
  }
  for (Surface& surface : world.surfaces) {
    if (surface.emission == Float3{}) continue;
    surface.emission =
        FactorOn(surface.source, look, look.view) * surface.emission;
    if (surface.source == kSky) surface.reflection = look.view_reflection;
  }
  AddScreenLights(world);
  // Lamps that are out take no time.
  std::erase_if(world.lights, [](const AreaLight& light) {
    return light.radiance == Float3{};
  });
}

}  // namespace treeline::worlds
