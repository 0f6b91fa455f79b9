#include "simulation/renderer/light_volume.h"

#include <algorithm>
#include <cmath>

#include "common/base/parallel_for.h"
#include "common/base/random.h"
#include "simulation/renderer/direct_light.h"
#include "simulation/renderer/indirect_light.h"

namespace treeline::renderer {
namespace {

constexpr float kSpacing_m = 0.5f;
constexpr double kMaxProbes = 12000;
constexpr size_t kRays = 96;
constexpr float kPi = 3.14159265f;
// Of a probe's rays, as many may meet the backs of surfaces before it counts
// as inside of something.
constexpr float kMaxBacks = 0.3f;

constexpr std::array<worlds::Float3, 6> kSides = {worlds::Float3{1, 0, 0},
                                                  {-1, 0, 0},
                                                  {0, 1, 0},
                                                  {0, -1, 0},
                                                  {0, 0, 1},
                                                  {0, 0, -1}};

struct Bounds {
  worlds::Float3 low{1e9f, 1e9f, 1e9f};
  worlds::Float3 high{-1e9f, -1e9f, -1e9f};

  void Add(worlds::Float3 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y),
            std::max(high.z, p.z)};
  }
};

// Evenly over the sphere (a Fibonacci lattice), turned by chance.
std::array<worlds::Float3, kRays> SphereDirections(float turn) {
  constexpr float kGolden = 2.39996323f;
  std::array<worlds::Float3, kRays> directions;
  for (size_t i = 0; i < kRays; ++i) {
    const float z = 1 - (2 * static_cast<float>(i) + 1) / kRays;
    const float radius = std::sqrt(1 - z * z);
    const float angle = turn + kGolden * static_cast<float>(i);
    directions[i] = {radius * std::cos(angle), radius * std::sin(angle), z};
  }
  return directions;
}

// Adds what comes straight from the sun.
void AddSun(const worlds::World& world, const RayCaster& caster,
            worlds::Float3 point, std::array<worlds::Float3, 6>& sides) {
  for (const worlds::Sunbeam& beam : world.sunbeams) {
    const worlds::Float3 sun = SunAt(beam, caster, point);
    for (size_t side = 0; side < kSides.size(); ++side) {
      const float facing = worlds::Dot(beam.to_sun, kSides[side]);
      if (facing > 0) sides[side] = sides[side] + facing * sun;
    }
  }
}

// Adds what comes straight from the lamps.
void AddLamps(const worlds::World& world, const RayCaster& caster,
              worlds::Float3 point, std::array<worlds::Float3, 6>& sides) {
  constexpr int kStrata = 2;
  for (const worlds::AreaLight& light : world.lights) {
    const worlds::Float3 area_normal = light.AreaNormal();
    for (int i = 0; i < kStrata * kStrata; ++i) {
      const float s = (static_cast<float>(i % kStrata) + 0.5f) / kStrata;
      const float t = (static_cast<float>(i / kStrata) + 0.5f) / kStrata;
      const worlds::Float3 from =
          light.corner + s * light.edge_u + t * light.edge_v;
      const worlds::Float3 way = from - point;
      const float leaving = -worlds::Dot(way, area_normal);
      if (leaving <= 0) continue;
      const float squared = std::max(worlds::Dot(way, way), 0.04f);
      const float share =
          leaving / (squared * squared) / (kStrata * kStrata * kPi);
      // A white wall in full light is about 1: a thousandth is nothing.
      const float most =
          std::max({light.radiance.x, light.radiance.y, light.radiance.z});
      if (share * std::sqrt(squared) * most < 2e-4f) continue;
      if (!caster.IsFree(point, from)) continue;
      for (size_t side = 0; side < kSides.size(); ++side) {
        const float facing = worlds::Dot(way, kSides[side]);
        if (facing > 0) {
          sides[side] = sides[side] + (share * facing) * light.radiance;
        }
      }
    }
  }
}

// Adds what surfaces reflect and shades give off. Returns the share of rays
// that met a surface's back.
float AddSurroundings(const worlds::World& world, const RayCaster& caster,
                      const LightMap& light_map, worlds::Float3 point,
                      float turn, std::array<worlds::Float3, 6>& sides) {
  const std::array<worlds::Float3, kRays> directions = SphereDirections(turn);
  std::array<RayHit, kRays> hits;
  caster.CastMany(point, directions, hits);
  float backs = 0;
  for (size_t i = 0; i < kRays; ++i) {
    if (hits[i].surface == RayHit::kNothing) continue;
    const worlds::Surface& surface = world.surfaces[hits[i].surface];
    if (worlds::Dot(surface.Normal(), directions[i]) > 0) backs += 1;
    const worlds::Float3 light =
        light_map.At(hits[i].surface, hits[i].u, hits[i].v);
    const worlds::Float3 radiance =
        GivenOn(world, surface, light) *
        world.textures[static_cast<size_t>(surface.texture)].Mean();
    for (size_t side = 0; side < kSides.size(); ++side) {
      const float facing = worlds::Dot(directions[i], kSides[side]);
      if (facing > 0) {
        sides[side] = sides[side] + (4 * facing / kRays) * radiance;
      }
    }
  }
  return backs / kRays;
}

}  // namespace

LightVolume LightVolume::Even() {
  LightVolume volume;
  volume.counts_ = {1, 1, 1};
  volume.probes_.resize(1);
  for (size_t side = 0; side < kSides.size(); ++side) {
    volume.probes_[0].sides[side] = LightMap::EvenLight(kSides[side]);
  }
  return volume;
}

LightVolume LightVolume::Bake(const worlds::World& world,
                              const RayCaster& caster,
                              const LightMap& light_map, int threads) {
  LightVolume volume;
  Bounds bounds;
  for (const worlds::Surface& surface : world.surfaces) {
    for (const worlds::Float3& corner : surface.corners) bounds.Add(corner);
  }
  if (world.surfaces.empty()) return volume;
  const worlds::Float3 size = bounds.high - bounds.low;
  const double cells = (size.x / kSpacing_m + 1.0) *
                       (size.y / kSpacing_m + 1.0) *
                       (size.z / kSpacing_m + 1.0);
  volume.spacing_m_ =
      kSpacing_m *
      static_cast<float>(std::cbrt(std::max(cells / kMaxProbes, 1.0)));
  const float spacing_m = volume.spacing_m_;
  const auto count = [spacing_m](float length_m) {
    return std::max(static_cast<int>(std::ceil(length_m / spacing_m)), 1);
  };
  volume.counts_ = {count(size.x), count(size.y), count(size.z)};
  // Probes are in the middles of cells.
  volume.low_ = bounds.low;
  const auto [nx, ny, nz] = volume.counts_;
  volume.probes_.resize(static_cast<size_t>(nx) * static_cast<size_t>(ny) *
                        static_cast<size_t>(nz));
  base::ParallelFor(
      int64_t{ny} * nz, threads, [&, nx = nx, ny = ny](int64_t row) {
        for (int x = 0; x < nx; ++x) {
          const worlds::Float3 cell = {static_cast<float>(x) + 0.5f,
                                       static_cast<float>(row % ny) + 0.5f,
                                       static_cast<float>(row / ny) + 0.5f};
          const worlds::Float3 point = volume.low_ + spacing_m * cell;
          const size_t index =
              static_cast<size_t>(row) * static_cast<size_t>(nx) +
              static_cast<size_t>(x);
          Probe& probe = volume.probes_[index];
          base::Random random(9, index);
          AddLamps(world, caster, point, probe.sides);
          AddSun(world, caster, point, probe.sides);
          const float backs = AddSurroundings(
              world, caster, light_map, point,
              static_cast<float>(random.NextUniform(0, 2.0 * kPi)),
              probe.sides);
          probe.weight = backs > kMaxBacks ? 0 : 1;
        }
      });
  return volume;
}

worlds::Float3 LightVolume::At(worlds::Float3 point,
                               worlds::Float3 normal) const {
  if (probes_.empty()) return {};
  const worlds::Float3 in_cells = (1 / spacing_m_) * (point - low_);
  const float at[3] = {in_cells.x - 0.5f, in_cells.y - 0.5f, in_cells.z - 0.5f};
  std::array<int, 3> first{};
  std::array<float, 3> share{};
  for (size_t k = 0; k < 3; ++k) {
    const float place =
        std::clamp(at[k], 0.0f, static_cast<float>(counts_[k] - 1));
    first[k] = std::min(static_cast<int>(place), std::max(counts_[k] - 2, 0));
    share[k] = place - static_cast<float>(first[k]);
  }
  const std::array<float, 6> squares = {normal.x > 0 ? normal.x * normal.x : 0,
                                        normal.x < 0 ? normal.x * normal.x : 0,
                                        normal.y > 0 ? normal.y * normal.y : 0,
                                        normal.y < 0 ? normal.y * normal.y : 0,
                                        normal.z > 0 ? normal.z * normal.z : 0,
                                        normal.z < 0 ? normal.z * normal.z : 0};
  worlds::Float3 sum;
  float weights = 0;
  for (int corner = 0; corner < 8; ++corner) {
    size_t index = 0;
    float part = 1;
    for (int k = 2; k >= 0; --k) {
      const size_t axis = static_cast<size_t>(k);
      const int step = (corner >> k) & 1;
      part *= step == 1 ? share[axis] : 1 - share[axis];
      index =
          index * static_cast<size_t>(counts_[axis]) +
          static_cast<size_t>(std::min(first[axis] + step, counts_[axis] - 1));
    }
    const Probe& probe = probes_[index];
    // Where all are inside of something, they must do.
    const float weight = part * std::max(probe.weight, 1e-4f) + 1e-9f;
    for (size_t side = 0; side < 6; ++side) {
      if (squares[side] > 0) {
        sum = sum + (weight * squares[side]) * probe.sides[side];
      }
    }
    weights += weight;
  }
  return (1 / weights) * sum;
}

}  // namespace treeline::renderer
