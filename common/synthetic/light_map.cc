#include "common/synthetic/light_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/parallel_for.h"
#include "common/base/random.h"

namespace treeline {
namespace {

constexpr float kTexel_m = 0.06f;
constexpr int kMaxTexels = 128;
constexpr int kLightStrata = 4;   // squared: samples of a light
constexpr int kGatherStrata = 8;  // squared: rays of the first bounce
constexpr int kBounces = 2;
constexpr float kPi = 3.14159265f;
constexpr float kLift_m = 0.002f;

// A point on a surface where light is computed.
struct Receiver {
  uint32_t surface = 0;
  Float3 point;
  Float3 normal;
};

float UnitFloat(Random& random) {
  return static_cast<float>(random.NextUnit());
}

Float3 DirectLight(const World& world, const RayCaster& caster,
                   const Receiver& receiver, Random& random) {
  Float3 total;
  for (const AreaLight& light : world.lights) {
    const Float3 area_normal = light.AreaNormal();
    Float3 sum;
    for (int i = 0; i < kLightStrata * kLightStrata; ++i) {
      const float s =
          (static_cast<float>(i % kLightStrata) + UnitFloat(random)) /
          kLightStrata;
      const float t =
          (static_cast<float>(i / kLightStrata) + UnitFloat(random)) /
          kLightStrata;
      const Float3 from = light.corner + s * light.edge_u + t * light.edge_v;
      const Float3 way = from - receiver.point;
      const float squared_distance = std::max(Dot(way, way), 0.01f);
      const float cosines = -Dot(way, area_normal) * Dot(way, receiver.normal);
      if (Dot(way, receiver.normal) <= 0 || Dot(way, area_normal) >= 0) {
        continue;
      }
      if (!caster.IsFree(receiver.point, from)) continue;
      sum = sum +
            (cosines / (squared_distance * squared_distance)) * light.radiance;
    }
    total = total + (1.0f / (kLightStrata * kLightStrata * kPi)) * sum;
  }
  return total;
}

// Directions about the normal in proportion to their cosine, stratified.
Float3 CosineDirection(const Receiver& receiver, int i, Random& random) {
  const float a = (static_cast<float>(i % kGatherStrata) + UnitFloat(random)) /
                  kGatherStrata;
  const float b = (static_cast<float>(i / kGatherStrata) + UnitFloat(random)) /
                  kGatherStrata;
  const float radius = std::sqrt(a);
  const Float3& n = receiver.normal;
  const Float3 helper =
      std::abs(n.z) < 0.9f ? Float3{0, 0, 1} : Float3{1, 0, 0};
  const Float3 x = Normalized(Cross(helper, n));
  const Float3 y = Cross(n, x);
  return (radius * std::cos(2 * kPi * b)) * x +
         (radius * std::sin(2 * kPi * b)) * y + std::sqrt(1 - a) * n;
}

// The mean over a texel and its neighbours: takes the grain out of what comes
// from all around, and so is smooth anyway.
void Smooth(int u_count, int v_count, const Float3* in, Float3* out) {
  for (int v = 0; v < v_count; ++v) {
    for (int u = 0; u < u_count; ++u) {
      Float3 sum;
      float count = 0;
      for (int y = std::max(v - 1, 0); y <= std::min(v + 1, v_count - 1); ++y) {
        for (int x = std::max(u - 1, 0); x <= std::min(u + 1, u_count - 1);
             ++x) {
          sum = sum + in[y * u_count + x];
          count += 1;
        }
      }
      out[v * u_count + u] = (1 / count) * sum;
    }
  }
}

}  // namespace

Float3 LightMap::At(uint32_t surface, float u, float v) const {
  const Grid& grid = grids_[surface];
  const auto place = [](float at, int count) {
    return std::clamp(at * static_cast<float>(count) - 0.5f, 0.0f,
                      static_cast<float>(count - 1));
  };
  const float x = place(u, grid.u_count);
  const float y = place(v, grid.v_count);
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, grid.u_count - 1);
  const int y1 = std::min(y0 + 1, grid.v_count - 1);
  const Float3* texels = texels_.data() + grid.first;
  const float tx = x - static_cast<float>(x0);
  const float ty = y - static_cast<float>(y0);
  return Mix(
      Mix(texels[y0 * grid.u_count + x0], texels[y0 * grid.u_count + x1], tx),
      Mix(texels[y1 * grid.u_count + x0], texels[y1 * grid.u_count + x1], tx),
      ty);
}

Float3 LightMap::EvenLight(Float3 normal) {
  const float light =
      0.30f + 0.08f * normal.z + 0.03f * normal.x - 0.05f * normal.y * normal.y;
  return {light, light, light};
}

LightMap LightMap::Even(const World& world) {
  LightMap map;
  map.texels_.reserve(world.surfaces.size());
  for (const Surface& surface : world.surfaces) {
    map.grids_.push_back({.first = map.texels_.size()});
    map.texels_.push_back(EvenLight(surface.Normal()));
  }
  return map;
}

LightMap LightMap::Bake(const World& world, const RayCaster& caster,
                        int threads) {
  LightMap map;
  std::vector<Receiver> receivers;
  for (size_t s = 0; s < world.surfaces.size(); ++s) {
    const Surface& surface = world.surfaces[s];
    const auto count = [](float length_m) {
      return std::clamp(static_cast<int>(std::lround(length_m / kTexel_m)), 1,
                        kMaxTexels);
    };
    const Grid grid{.u_count = count(surface.LengthU()),
                    .v_count = count(surface.LengthV()),
                    .first = receivers.size()};
    const Float3 normal = surface.Normal();
    for (int i = 0; i < grid.u_count * grid.v_count; ++i) {
      const float u = (static_cast<float>(i % grid.u_count) + 0.5f) /
                      static_cast<float>(grid.u_count);
      const float v = (static_cast<float>(i / grid.u_count) + 0.5f) /
                      static_cast<float>(grid.v_count);
      receivers.push_back({static_cast<uint32_t>(s),
                           surface.PointAt(u, v) + kLift_m * normal, normal});
    }
    map.grids_.push_back(grid);
  }

  // Work is handed out by the row of a few hundred texels.
  constexpr size_t kChunk = 256;
  const auto for_all = [&](auto&& body) {
    const size_t chunks = (receivers.size() + kChunk - 1) / kChunk;
    ParallelFor(static_cast<int64_t>(chunks), threads, [&](int64_t chunk) {
      const size_t first = static_cast<size_t>(chunk) * kChunk;
      const size_t last = std::min(first + kChunk, receivers.size());
      for (size_t i = first; i < last; ++i) body(i);
    });
  };
  std::vector<Float3> direct(receivers.size());
  for_all([&](size_t i) {
    Random random(1, i);
    direct[i] = DirectLight(world, caster, receivers[i], random);
  });
  map.texels_ = direct;
  std::vector<Float3> gathered(receivers.size());
  std::vector<Float3> smooth(receivers.size());
  for (int bounce = 0; bounce < kBounces; ++bounce) {
    for_all([&](size_t i) {
      Random random(2 + static_cast<uint64_t>(bounce), i);
      constexpr size_t kRays = kGatherStrata * kGatherStrata;
      std::array<Float3, kRays> directions;
      std::array<RayHit, kRays> hits;
      for (size_t ray = 0; ray < kRays; ++ray) {
        directions[ray] =
            CosineDirection(receivers[i], static_cast<int>(ray), random);
      }
      caster.CastMany(receivers[i].point, directions, hits);
      Float3 sum;
      for (const RayHit& hit : hits) {
        if (hit.surface == RayHit::kNothing) continue;
        const Surface& other = world.surfaces[hit.surface];
        const Float3 light =
            map.At(hit.surface, hit.u, hit.v) +
            Float3{other.emission, other.emission, other.emission};
        sum = sum +
              light * world.textures[static_cast<size_t>(other.texture)].Mean();
      }
      gathered[i] = (1.0f / kRays) * sum;
    });
    for (const Grid& grid : map.grids_) {
      Smooth(grid.u_count, grid.v_count, gathered.data() + grid.first,
             smooth.data() + grid.first);
    }
    for_all([&](size_t i) { map.texels_[i] = direct[i] + smooth[i]; });
  }
  return map;
}

}  // namespace treeline
