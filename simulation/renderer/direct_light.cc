#include "simulation/renderer/direct_light.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace treeline::renderer {
namespace {

constexpr int kLightStrata = 4;  // squared: samples of a light
constexpr float kPi = 3.14159265f;
// Light that nobody would see; a white wall in full light is 1.
constexpr float kFaint = 0.0005f;
// Lights so near are sampled without asking whether they are seen.
constexpr float kNear_m = 1.5f;

float UnitFloat(base::Random& random) {
  return static_cast<float>(random.NextUnit());
}

// What one point of a light gives a receiver.
worlds::Float3 LightFrom(const worlds::AreaLight& light,
                         worlds::Float3 area_normal, worlds::Float3 from,
                         const RayCaster& caster,
                         const LightReceiver& receiver) {
  const worlds::Float3 way = from - receiver.point;
  if (worlds::Dot(way, receiver.normal) <= 0 ||
      worlds::Dot(way, area_normal) >= 0)
    return {};
  if (!caster.IsFree(receiver.point, from)) return {};
  const float squared_distance = std::max(worlds::Dot(way, way), 0.01f);
  const float cosines =
      -worlds::Dot(way, area_normal) * worlds::Dot(way, receiver.normal);
  return (cosines / (squared_distance * squared_distance)) * light.radiance;
}

// A random point of one of kLightStrata^2 parts of a light.
worlds::Float3 PointOnPart(const worlds::AreaLight& light, int part,
                           base::Random& random) {
  const float s =
      (static_cast<float>(part % kLightStrata) + UnitFloat(random)) /
      kLightStrata;
  const float t =
      (static_cast<float>(part / kLightStrata) + UnitFloat(random)) /
      kLightStrata;
  return light.corner + s * light.edge_u + t * light.edge_v;
}

// Whether some points of a light can be seen from here, or it is near.
bool MaySee(const worlds::AreaLight& light, const RayCaster& caster,
            const LightReceiver& receiver) {
  const worlds::Float3 area_normal = light.AreaNormal();
  const float most =
      std::max({light.radiance.x, light.radiance.y, light.radiance.z});
  for (const float at : {0.1f, 0.5f, 0.9f}) {
    const worlds::Float3 from =
        light.corner + at * light.edge_u + at * light.edge_v;
    const worlds::Float3 way = from - receiver.point;
    const float squared = std::max(worlds::Dot(way, way), 0.01f);
    if (squared < kNear_m * kNear_m) return true;
    if (most * worlds::Norm(area_normal) / (kPi * squared) < kFaint) continue;
    if (worlds::Dot(way, receiver.normal) <= 0 ||
        worlds::Dot(way, area_normal) >= 0)
      continue;
    if (caster.IsFree(receiver.point, from)) return true;
  }
  return false;
}

}  // namespace

worlds::Float3 DirectLight(const worlds::World& world, const RayCaster& caster,
                           const LightReceiver& receiver,
                           base::Random& random) {
  worlds::Float3 total;
  for (const worlds::AreaLight& light : world.lights) {
    const worlds::Float3 area_normal = light.AreaNormal();
    worlds::Float3 sum;
    for (int i = 0; i < kLightStrata * kLightStrata; ++i) {
      const worlds::Float3 from = PointOnPart(light, i, random);
      sum = sum + LightFrom(light, area_normal, from, caster, receiver);
    }
    total = total + (1.0f / (kLightStrata * kLightStrata * kPi)) * sum;
  }
  return total;
}

worlds::Float3 QuickDirectLight(const worlds::World& world,
                                std::span<const size_t> lights,
                                const RayCaster& caster,
                                const LightReceiver& receiver,
                                base::Random& random) {
  constexpr int kParts = kLightStrata * kLightStrata;
  // One in each quarter of the light, then the others.
  constexpr std::array<int, kParts> kOrder = {0, 6, 9, 15, 1,  2,  3,  4,
                                              5, 7, 8, 10, 11, 12, 13, 14};
  worlds::Float3 total;
  for (const size_t index : lights) {
    const worlds::AreaLight& light = world.lights[index];
    const worlds::Float3 area_normal = light.AreaNormal();
    worlds::Float3 sum;
    int lit = 0;
    int parts = 0;
    while (parts < kParts && (parts != 4 || (lit != 0 && lit != 4))) {
      const worlds::Float3 from =
          PointOnPart(light, kOrder[static_cast<size_t>(parts)], random);
      const worlds::Float3 part =
          LightFrom(light, area_normal, from, caster, receiver);
      if (part.x + part.y + part.z > 0) ++lit;
      sum = sum + part;
      ++parts;
    }
    total = total + (1.0f / (static_cast<float>(parts) * kPi)) * sum;
  }
  return total;
}

std::vector<size_t> LightsOf(const worlds::World& world,
                             const RayCaster& caster,
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

}  // namespace treeline::renderer
