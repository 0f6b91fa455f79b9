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
                             std::span<const LightReceiver> patch) {
  std::vector<size_t> lights;
  for (size_t i = 0; i < world.lights.size(); ++i) {
    const AreaLight& light = world.lights[i];
    const Float3 area_normal = light.AreaNormal();
    const float most =
        std::max({light.radiance.x, light.radiance.y, light.radiance.z});
    bool is_seen = false;
    const size_t step = std::max<size_t>(patch.size() / 5, 1);
    for (size_t k = 0; k < patch.size() && !is_seen; k += step) {
      for (const float at : {0.1f, 0.5f, 0.9f}) {
        const Float3 from =
            light.corner + at * light.edge_u + at * light.edge_v;
        const Float3 way = from - patch[k].point;
        const float squared = std::max(Dot(way, way), 0.01f);
        const float bound = most * Norm(area_normal) / (kPi * squared);
        if (bound < kFaint) continue;
        if (Dot(way, patch[k].normal) <= -0.5f || Dot(way, area_normal) >= 0) {
          continue;
        }
        if (caster.IsFree(patch[k].point, from)) {
          is_seen = true;
          break;
        }
      }
    }
    if (is_seen) lights.push_back(i);
  }
  return lights;
}

}  // namespace treeline
