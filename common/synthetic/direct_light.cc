#include "common/synthetic/direct_light.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace treeline {
namespace {

constexpr int kLightStrata = 4;  // squared: samples of a light
constexpr float kPi = 3.14159265f;
// Light that nobody would see; a white wall in full light is 1.
constexpr float kFaint = 0.0005f;
// Lights so near are sampled without asking whether they are seen.
constexpr float kNear_m = 1.5f;

float UnitFloat(Random& random) {
  return static_cast<float>(random.NextUnit());
}

// What one point of a light gives a receiver.
Float3 LightFrom(const AreaLight& light, Float3 area_normal, Float3 from,
                 const RayCaster& caster, const LightReceiver& receiver) {
  const Float3 way = from - receiver.point;
  if (Dot(way, receiver.normal) <= 0 || Dot(way, area_normal) >= 0) return {};
  if (!caster.IsFree(receiver.point, from)) return {};
  const float squared_distance = std::max(Dot(way, way), 0.01f);
  const float cosines = -Dot(way, area_normal) * Dot(way, receiver.normal);
  return (cosines / (squared_distance * squared_distance)) * light.radiance;
}

// A random point of one of kLightStrata^2 parts of a light.
Float3 PointOnPart(const AreaLight& light, int part, Random& random) {
  const float s =
      (static_cast<float>(part % kLightStrata) + UnitFloat(random)) /
      kLightStrata;
  const float t =
      (static_cast<float>(part / kLightStrata) + UnitFloat(random)) /
      kLightStrata;
  return light.corner + s * light.edge_u + t * light.edge_v;
}

// Whether some points of a light can be seen from here, or it is near.
bool MaySee(const AreaLight& light, const RayCaster& caster,
            const LightReceiver& receiver) {
  const Float3 area_normal = light.AreaNormal();
  const float most =
      std::max({light.radiance.x, light.radiance.y, light.radiance.z});
  for (const float at : {0.1f, 0.5f, 0.9f}) {
    const Float3 from = light.corner + at * light.edge_u + at * light.edge_v;
    const Float3 way = from - receiver.point;
    const float squared = std::max(Dot(way, way), 0.01f);
    if (squared < kNear_m * kNear_m) return true;
    if (most * Norm(area_normal) / (kPi * squared) < kFaint) continue;
    if (Dot(way, receiver.normal) <= 0 || Dot(way, area_normal) >= 0) continue;
    if (caster.IsFree(receiver.point, from)) return true;
  }
  return false;
}

}  // namespace

Float3 DirectLight(const World& world, const RayCaster& caster,
                   const LightReceiver& receiver, Random& random) {
  Float3 total;
  for (const AreaLight& light : world.lights) {
    const Float3 area_normal = light.AreaNormal();
    Float3 sum;
    for (int i = 0; i < kLightStrata * kLightStrata; ++i) {
      const Float3 from = PointOnPart(light, i, random);
      sum = sum + LightFrom(light, area_normal, from, caster, receiver);
    }
    total = total + (1.0f / (kLightStrata * kLightStrata * kPi)) * sum;
  }
  return total;
}

Float3 QuickDirectLight(const World& world, std::span<const size_t> lights,
                        const RayCaster& caster, const LightReceiver& receiver,
                        Random& random) {
  constexpr int kParts = kLightStrata * kLightStrata;
  // One in each quarter of the light, then the others.
  constexpr std::array<int, kParts> kOrder = {0, 6, 9, 15, 1,  2,  3,  4,
                                              5, 7, 8, 10, 11, 12, 13, 14};
  Float3 total;
  for (const size_t index : lights) {
    const AreaLight& light = world.lights[index];
    const Float3 area_normal = light.AreaNormal();
    Float3 sum;
    int lit = 0;
    int parts = 0;
    while (parts < kParts && (parts != 4 || (lit != 0 && lit != 4))) {
      const Float3 from =
          PointOnPart(light, kOrder[static_cast<size_t>(parts)], random);
      const Float3 part = LightFrom(light, area_normal, from, caster, receiver);
      if (part.x + part.y + part.z > 0) ++lit;
      sum = sum + part;
      ++parts;
    }
    total = total + (1.0f / (static_cast<float>(parts) * kPi)) * sum;
  }
  return total;
}

std::vector<size_t> LightsOf(const World& world, const RayCaster& caster,
                             std::span<const LightReceiver> patch,
                             size_t width) {
  // Corners, middles of sides, and the middle.
  std::vector<size_t> asked;
  const size_t height = patch.size() / width;
  for (const size_t y : {size_t{0}, height / 2, height - 1}) {
    for (const size_t x : {size_t{0}, width / 2, width - 1}) {
      asked.push_back(y * width + x);
    }
  }
  std::sort(asked.begin(), asked.end());
  asked.erase(std::unique(asked.begin(), asked.end()), asked.end());
  std::vector<size_t> lights;
  for (size_t i = 0; i < world.lights.size(); ++i) {
    const auto sees = [&](size_t k) {
      return MaySee(world.lights[i], caster, patch[k]);
    };
    if (std::any_of(asked.begin(), asked.end(), sees)) lights.push_back(i);
  }
  return lights;
}

}  // namespace treeline
