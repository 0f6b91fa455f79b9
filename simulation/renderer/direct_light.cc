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

// Where a ray from `point` along `way` comes through a beam's window; false:
// nowhere.
bool MeetsWindow(const worlds::Sunbeam& beam, worlds::Float3 point,
                 worlds::Float3 way, worlds::Float3& meets) {
  const worlds::Float3 normal = worlds::Cross(beam.edge_v, beam.edge_u);
  const float towards = worlds::Dot(way, normal);
  // Windows let the sun in, not out.
  if (towards >= 0) return false;
  const float distance = worlds::Dot(beam.corner - point, normal) / towards;
  if (distance <= 0) return false;
  meets = point + distance * way;
  const worlds::Float3 in_window = meets - beam.corner;
  const float u = worlds::Dot(in_window, beam.edge_u);
  const float v = worlds::Dot(in_window, beam.edge_v);
  return u >= 0 && u <= worlds::Dot(beam.edge_u, beam.edge_u) && v >= 0 &&
         v <= worlds::Dot(beam.edge_v, beam.edge_v);
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

worlds::Float3 SunLight(const worlds::World& world, const RayCaster& caster,
                        const LightReceiver& receiver, base::Random& random) {
  constexpr int kStrata = 4;
  // The sun's radius is 0.27 degrees; panes and thin clouds widen it.
  constexpr float kSpread = 0.008f;
  worlds::Float3 total;
  if (world.sunbeams.empty()) return total;
  const worlds::Surface& surface = world.surfaces[receiver.surface];
  const worlds::Float3 lift =
      receiver.point - surface.PointAt(receiver.u, receiver.v);
  for (int i = 0; i < kStrata * kStrata; ++i) {
    const auto part = [&random](int stratum) {
      return (static_cast<float>(stratum) + UnitFloat(random)) / kStrata - 0.5f;
    };
    const float u = receiver.u + part(i % kStrata) * receiver.step_u;
    const float v = receiver.v + part(i / kStrata) * receiver.step_v;
    const worlds::Float3 point = surface.PointAt(u, v) + lift;
    const auto spread = [&random] {
      return kSpread * (2 * UnitFloat(random) - 1);
    };
    const worlds::Float3 aside = {spread(), spread(), spread()};
    for (const worlds::Sunbeam& beam : world.sunbeams) {
      const float cosine = worlds::Dot(beam.to_sun, receiver.normal);
      worlds::Float3 meets;
      if (cosine > 0 && MeetsWindow(beam, point, beam.to_sun + aside, meets) &&
          caster.IsFree(point, meets)) {
        total = total + cosine * beam.radiance;
      }
    }
  }
  return (1.0f / (kStrata * kStrata)) * total;
}

worlds::Float3 SunAt(const worlds::Sunbeam& beam, const RayCaster& caster,
                     worlds::Float3 point) {
  worlds::Float3 meets;
  if (!MeetsWindow(beam, point, beam.to_sun, meets) ||
      !caster.IsFree(point, meets)) {
    return {};
  }
  return beam.radiance;
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
