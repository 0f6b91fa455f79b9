#include "simulation/renderer/light_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/parallel_for.h"
#include "common/base/random.h"
#include "simulation/renderer/direct_light.h"
#include "simulation/renderer/indirect_light.h"

namespace treeline::renderer {

namespace {

constexpr float kTexel_m = 0.06f;
constexpr int kMaxTexels = 128;
// In larger worlds texels are larger instead.
constexpr float kTexelBudget = 350e3f;
// What comes from all around changes slowly: in worlds of more texels than
// this it is gathered for squares of 3 x 3 only.
constexpr size_t kFineGather = 120000;
// A coarse texel is so many wide.
constexpr float kCoarse = 3;
// Texels of one surface that are asked together which lights they see.
constexpr int kPatch = 8;
constexpr int kGatherStrata = 8;  // squared: rays of the first bounce
constexpr int kBounces = 2;
constexpr float kPi = 3.14159265f;
constexpr float kLift_m = 0.002f;

// Directions about the normal in proportion to their cosine, stratified.
worlds::Float3 CosineDirection(const LightReceiver& receiver, int i,
                               base::Random& random) {
  const auto part = [&random](int index) {
    return (static_cast<float>(index) + static_cast<float>(random.NextUnit())) /
           kGatherStrata;
  };
  const float a = part(i % kGatherStrata);
  const float b = part(i / kGatherStrata);
  const float radius = std::sqrt(a);
  const worlds::Float3& n = receiver.normal;
  const worlds::Float3 helper =
      std::abs(n.z) < 0.9f ? worlds::Float3{0, 0, 1} : worlds::Float3{1, 0, 0};
  const worlds::Float3 x = worlds::Normalized(worlds::Cross(helper, n));
  const worlds::Float3 y = worlds::Cross(n, x);
  return (radius * std::cos(2 * kPi * b)) * x +
         (radius * std::sin(2 * kPi * b)) * y + std::sqrt(1 - a) * n;
}

// The mean over a texel and its neighbours: takes the grain out of what comes
// from all around, and so is smooth anyway.
void Smooth(int u_count, int v_count, const worlds::Float3* in,
            worlds::Float3* out) {
  for (int v = 0; v < v_count; ++v) {
    for (int u = 0; u < u_count; ++u) {
      worlds::Float3 sum;
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

// Calls body(i) for each i below `count`, in parallel, some hundred at a time.
template <typename Body>
void ForAll(size_t count, int threads, const Body& body) {
  constexpr size_t kChunk = 256;
  const size_t chunks = (count + kChunk - 1) / kChunk;
  base::ParallelFor(static_cast<int64_t>(chunks), threads, [&](int64_t chunk) {
    const size_t first = static_cast<size_t>(chunk) * kChunk;
    const size_t last = std::min(first + kChunk, count);
    for (size_t i = first; i < last; ++i) body(i);
  });
}

float TexelSize_m(const worlds::World& world) {
  float area_m2 = 0;
  for (const worlds::Surface& surface : world.surfaces) {
    area_m2 += surface.LengthU() * surface.LengthV();
  }
  return std::max(kTexel_m, std::sqrt(area_m2 / kTexelBudget));
}

}  // namespace

worlds::Float3 LightMap::At(uint32_t surface, float u, float v) const {
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
  const worlds::Float3* texels = texels_.data() + grid.first;
  const float tx = x - static_cast<float>(x0);
  const float ty = y - static_cast<float>(y0);
  return worlds::Mix(worlds::Mix(texels[y0 * grid.u_count + x0],
                                 texels[y0 * grid.u_count + x1], tx),
                     worlds::Mix(texels[y1 * grid.u_count + x0],
                                 texels[y1 * grid.u_count + x1], tx),
                     ty);
}

worlds::Float3 LightMap::EvenLight(worlds::Float3 normal) {
  const float light =
      0.30f + 0.08f * normal.z + 0.03f * normal.x - 0.05f * normal.y * normal.y;
  return {light, light, light};
}

LightMap LightMap::Even(const worlds::World& world) {
  LightMap map;
  map.texels_.reserve(world.surfaces.size());
  for (const worlds::Surface& surface : world.surfaces) {
    map.grids_.push_back({.first = map.texels_.size()});
    map.texels_.push_back(EvenLight(surface.Normal()));
  }
  return map;
}

std::vector<LightMap::Patch> LightMap::Patches() const {
  std::vector<Patch> patches;
  for (const Grid& grid : grids_) {
    for (int top = 0; top < grid.v_count; top += kPatch) {
      for (int left = 0; left < grid.u_count; left += kPatch) {
        Patch& patch = patches.emplace_back();
        const int right = std::min(left + kPatch, grid.u_count);
        patch.width = static_cast<size_t>(right - left);
        for (int v = top; v < std::min(top + kPatch, grid.v_count); ++v) {
          for (int u = left; u < right; ++u) {
            patch.texels.push_back(grid.first +
                                   static_cast<size_t>(v * grid.u_count + u));
          }
        }
      }
    }
  }
  return patches;
}

std::vector<LightReceiver> LightMap::LayOut(const worlds::World& world,
                                            float texel_m) {
  std::vector<LightReceiver> receivers;
  grids_.clear();
  for (size_t s = 0; s < world.surfaces.size(); ++s) {
    const worlds::Surface& surface = world.surfaces[s];
    const auto count = [texel_m](float length_m) {
      return std::clamp(static_cast<int>(std::lround(length_m / texel_m)), 1,
                        kMaxTexels);
    };
    const Grid grid{.u_count = count(surface.LengthU()),
                    .v_count = count(surface.LengthV()),
                    .first = receivers.size()};
    const worlds::Float3 normal = surface.Normal();
    for (int i = 0; i < grid.u_count * grid.v_count; ++i) {
      const float u = (static_cast<float>(i % grid.u_count) + 0.5f) /
                      static_cast<float>(grid.u_count);
      const float v = (static_cast<float>(i / grid.u_count) + 0.5f) /
                      static_cast<float>(grid.v_count);
      receivers.push_back({.surface = static_cast<uint32_t>(s),
                           .u = u,
                           .v = v,
                           .step_u = 1 / static_cast<float>(grid.u_count),
                           .step_v = 1 / static_cast<float>(grid.v_count),
                           .point = surface.PointAt(u, v) + kLift_m * normal,
                           .normal = normal});
    }
    grids_.push_back(grid);
  }
  texels_.resize(receivers.size());
  return receivers;
}

std::vector<worlds::Float3> LightMap::Gather(
    const worlds::World& world, const RayCaster& caster,
    std::span<const LightReceiver> receivers, int bounce, bool is_front_only,
    int threads) const {
  std::vector<worlds::Float3> gathered(receivers.size());
  ForAll(receivers.size(), threads, [&](size_t i) {
    base::Random random(2 + static_cast<uint64_t>(bounce), i);
    constexpr size_t kRays = kGatherStrata * kGatherStrata;
    std::array<worlds::Float3, kRays> directions;
    std::array<RayHit, kRays> hits;
    for (size_t ray = 0; ray < kRays; ++ray) {
      directions[ray] =
          CosineDirection(receivers[i], static_cast<int>(ray), random);
    }
    caster.CastMany(receivers[i].point, directions, hits);
    worlds::Float3 sum;
    for (size_t ray = 0; ray < kRays; ++ray) {
      const RayHit& hit = hits[ray];
      if (hit.surface == RayHit::kNothing) continue;
      const worlds::Surface& other = world.surfaces[hit.surface];
      const bool is_dark =
          is_front_only && worlds::Dot(other.Normal(), directions[ray]) > 0;
      const worlds::Float3 light = At(hit.surface, hit.u, hit.v);
      const worlds::Float3 leaving =
          is_dark ? other.reflection * light : GivenOn(world, other, light);
      sum = sum +
            leaving * world.textures[static_cast<size_t>(other.texture)].Mean();
    }
    gathered[i] = (1.0f / kRays) * sum;
  });
  return gathered;
}

void LightMap::SmoothFrom(const std::vector<worlds::Float3>& gathered) {
  for (const Grid& grid : grids_) {
    Smooth(grid.u_count, grid.v_count, gathered.data() + grid.first,
           texels_.data() + grid.first);
  }
}

LightMap LightMap::Bake(const worlds::World& world, const RayCaster& caster,
                        int threads) {
  LightMap map;
  const std::vector<LightReceiver> receivers =
      map.LayOut(world, TexelSize_m(world));
  if (receivers.size() > kFineGather) {
    map.BakeLarge(world, caster, receivers, threads);
  } else {
    map.BakeSmall(world, caster, receivers, threads);
  }
  return map;
}

void LightMap::BakeSmall(const worlds::World& world, const RayCaster& caster,
                         std::span<const LightReceiver> receivers,
                         int threads) {
  std::vector<worlds::Float3> direct(receivers.size());
  ForAll(receivers.size(), threads, [&](size_t i) {
    base::Random random(1, i);
    direct[i] = DirectLight(world, caster, receivers[i], random) +
                SunLight(world, caster, receivers[i], random);
  });
  texels_ = direct;
  LightMap smooth = *this;
  for (int bounce = 0; bounce < kBounces; ++bounce) {
    smooth.SmoothFrom(Gather(world, caster, receivers, bounce,
                             /*is_front_only=*/false, threads));
    for (size_t i = 0; i < texels_.size(); ++i) {
      texels_[i] = direct[i] + smooth.texels_[i];
    }
  }
}

void LightMap::BakeLarge(const worlds::World& world, const RayCaster& caster,
                         std::span<const LightReceiver> receivers,
                         int threads) {
  std::vector<worlds::Float3> direct(receivers.size());
  const std::vector<Patch> patches = Patches();
  base::ParallelFor(
      static_cast<int64_t>(patches.size()), threads, [&](int64_t p) {
        const auto& [width, indices] = patches[static_cast<size_t>(p)];
        std::vector<LightReceiver> patch;
        for (const size_t i : indices) patch.push_back(receivers[i]);
        const std::vector<size_t> lights =
            LightsOf(world, caster, patch, width);
        for (const size_t i : indices) {
          base::Random random(1, i);
          direct[i] =
              QuickDirectLight(world, lights, caster, receivers[i], random) +
              SunLight(world, caster, receivers[i], random);
        }
      });
  texels_ = direct;
  LightMap coarse;
  const std::vector<LightReceiver> few =
      coarse.LayOut(world, kCoarse * TexelSize_m(world));
  for (int bounce = 0; bounce < kBounces; ++bounce) {
    coarse.SmoothFrom(Gather(world, caster, few, bounce,
                             /*is_front_only=*/true, threads));
    ForAll(receivers.size(), threads, [&](size_t i) {
      texels_[i] = direct[i] + coarse.At(receivers[i].surface, receivers[i].u,
                                         receivers[i].v);
    });
  }
}

}  // namespace treeline::renderer
