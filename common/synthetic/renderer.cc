#include "common/synthetic/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "common/base/parallel_for.h"
#include "common/base/status_macros.h"

namespace treeline {
namespace {

// Rows that one thread takes at a time.
constexpr int kRowBlock = 16;

Float3 ToFloat3(Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y),
          static_cast<float>(v.z)};
}

}  // namespace

PixelRays::PixelRays(const Camera& camera)
    : width_(camera.width()),
      height_(camera.height()),
      focal_length_px_(static_cast<float>((camera.fx() + camera.fy()) / 2)) {
  const size_t count =
      static_cast<size_t>(width_) * static_cast<size_t>(height_);
  rays_.reserve(count);
  inverse_lengths_.reserve(count);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const std::optional<Pixel> ray = camera.Unproject({1.0 * x, 1.0 * y});
      const Float3 direction =
          ray.has_value() ? ToFloat3({ray->x, ray->y, 1}) : Float3{0, 0, 0};
      rays_.push_back(direction);
      inverse_lengths_.push_back(direction.z > 0 ? 1 / Norm(direction) : 0);
    }
  }
}

struct Renderer::View {
  View(const PixelRays& pixel_rays, const Rigid3& world_from_camera)
      : rays(pixel_rays), origin(ToFloat3(world_from_camera.translation)) {
    const Mat3 matrix = world_from_camera.rotation.Matrix();
    x_axis = ToFloat3({matrix(0, 0), matrix(1, 0), matrix(2, 0)});
    y_axis = ToFloat3({matrix(0, 1), matrix(1, 1), matrix(2, 1)});
    z_axis = ToFloat3({matrix(0, 2), matrix(1, 2), matrix(2, 2)});
  }

  Float3 DirectionInWorld(Float3 ray) const {
    return ray.x * x_axis + ray.y * y_axis + ray.z * z_axis;
  }

  const PixelRays& rays;
  Float3 origin;
  // The camera's axes in the world.
  Float3 x_axis;
  Float3 y_axis;
  Float3 z_axis;
};

absl::StatusOr<std::unique_ptr<const Renderer>> Renderer::Create(World world,
                                                                 int threads) {
  TL_ASSIGN_OR_RETURN(RayCaster caster, RayCaster::Create(world));
  LightMap light_map = LightMap::Bake(world, caster, threads);
  return std::unique_ptr<const Renderer>(
      new Renderer(std::move(world), std::move(caster), std::move(light_map)));
}

Renderer::Renderer(World world, RayCaster caster, LightMap light_map)
    : world_(std::move(world)),
      caster_(std::move(caster)),
      light_map_(std::move(light_map)) {
  shadings_.reserve(world_.surfaces.size());
  for (const Surface& surface : world_.surfaces) {
    const Texture& texture =
        world_.textures[static_cast<size_t>(surface.texture)];
    const auto texels = [&](const std::array<float, 2>& step) {
      return std::hypot(step[0] * static_cast<float>(texture.width()),
                        step[1] * static_cast<float>(texture.height()));
    };
    shadings_.push_back({.normal = surface.Normal(),
                         .texels_per_m = std::max(
                             texels(surface.texture_u) / surface.LengthU(),
                             texels(surface.texture_v) / surface.LengthV())});
  }
}

void Renderer::CastRows(const View& view, int first_row, int last_row,
                        std::vector<RayHit>& hits) const {
  const size_t width = static_cast<size_t>(view.rays.width());
  std::vector<Float3> directions(width);
  for (int row = first_row; row < last_row; ++row) {
    const size_t first = static_cast<size_t>(row) * width;
    for (size_t x = 0; x < width; ++x) {
      const Float3 ray = view.rays.rays()[first + x];
      directions[x] = view.DirectionInWorld(ray.z > 0 ? ray : Float3{0, 0, 1});
    }
    const std::span<RayHit> row_hits(hits.data() + first, width);
    caster_.CastMany(view.origin, directions, row_hits);
    for (size_t x = 0; x < width; ++x) {
      if (!(view.rays.rays()[first + x].z > 0)) row_hits[x] = RayHit();
    }
  }
}

Float3 Renderer::Shade(const View& view, Float3 direction, float inverse_length,
                       const RayHit& hit) const {
  if (hit.surface == RayHit::kNothing) return {};
  const Surface& surface = world_.surfaces[hit.surface];
  const Shading& shading = shadings_[hit.surface];
  // A pixel covers distance / f on a surface that faces the camera, more on a
  // slanted one; the root of the slant is a compromise between blur and
  // flicker.
  const float incidence =
      std::abs(Dot(direction, shading.normal)) * inverse_length;
  const float texels =
      hit.distance * shading.texels_per_m / view.rays.focal_length_px();
  const float squared_texels = texels * texels / std::max(incidence, 0.02f);
  const float s = surface.texture_origin[0] + hit.u * surface.texture_u[0] +
                  hit.v * surface.texture_v[0];
  const float t = surface.texture_origin[1] + hit.u * surface.texture_u[1] +
                  hit.v * surface.texture_v[1];
  const Float3 reflectance =
      world_.textures[static_cast<size_t>(surface.texture)].Sample(
          s, t, squared_texels);
  const Float3 light = light_map_.At(hit.surface, hit.u, hit.v);
  return reflectance *
         (light + Float3{surface.emission, surface.emission, surface.emission});
}

void Renderer::ShadeEdges(const View& view, const std::vector<size_t>& edges,
                          std::vector<Float3>& radiance) const {
  // On a slanted line through the middle, whose ray is there already; the
  // slant alternates, so that no direction of edges is left jagged.
  constexpr float kAcross_px = 0.33f;
  constexpr float kDown_px = 0.17f;
  const float pixel_size = 1 / view.rays.focal_length_px();
  const size_t width = static_cast<size_t>(view.rays.width());
  std::vector<Float3> directions;
  directions.reserve(2 * edges.size());
  for (const size_t pixel : edges) {
    const Float3 ray = view.rays.rays()[pixel];
    const bool is_rising = (pixel % width + pixel / width) % 2 == 0;
    const float x = pixel_size * (is_rising ? kAcross_px : kDown_px);
    const float y = pixel_size * (is_rising ? -kDown_px : kAcross_px);
    directions.push_back(view.DirectionInWorld({ray.x + x, ray.y + y, 1}));
    directions.push_back(view.DirectionInWorld({ray.x - x, ray.y - y, 1}));
  }
  std::vector<RayHit> hits(directions.size());
  caster_.CastMany(view.origin, directions, hits);
  for (size_t i = 0; i < edges.size(); ++i) {
    const float inverse_length = view.rays.inverse_lengths()[edges[i]];
    Float3 sum = radiance[edges[i]];
    for (size_t k = 2 * i; k < 2 * i + 2; ++k) {
      sum = sum + Shade(view, directions[k], inverse_length, hits[k]);
    }
    radiance[edges[i]] = (1.0f / 3) * sum;
  }
}

std::vector<Float3> Renderer::RenderRadiance(const PixelRays& rays,
                                             const Rigid3& world_from_camera,
                                             int threads) const {
  const View view(rays, world_from_camera);
  const int height = rays.height();
  const size_t width = static_cast<size_t>(rays.width());
  const int blocks = (height + kRowBlock - 1) / kRowBlock;
  std::vector<RayHit> hits(rays.rays().size());
  ParallelFor(blocks, threads, [&](int64_t block) {
    const int first = static_cast<int>(block) * kRowBlock;
    CastRows(view, first, std::min(first + kRowBlock, height), hits);
  });
  std::vector<Float3> radiance(hits.size());
  const size_t last_row = hits.size() - width;
  ParallelFor(blocks, threads, [&](int64_t block) {
    const int first = static_cast<int>(block) * kRowBlock;
    const int last = std::min(first + kRowBlock, height);
    std::vector<size_t> edges;
    for (size_t i = static_cast<size_t>(first) * width;
         i < static_cast<size_t>(last) * width; ++i) {
      if (!(rays.rays()[i].z > 0)) continue;
      const uint32_t surface = hits[i].surface;
      const size_t x = i % width;
      if ((x > 0 && hits[i - 1].surface != surface) ||
          (x + 1 < width && hits[i + 1].surface != surface) ||
          (i >= width && hits[i - width].surface != surface) ||
          (i < last_row && hits[i + width].surface != surface)) {
        edges.push_back(i);
      }
      radiance[i] = Shade(view, view.DirectionInWorld(rays.rays()[i]),
                          rays.inverse_lengths()[i], hits[i]);
    }
    ShadeEdges(view, edges, radiance);
  });
  return radiance;
}

std::vector<DepthSample> Renderer::RenderDepth(const PixelRays& rays,
                                               const Rigid3& world_from_camera,
                                               int threads) const {
  const View view(rays, world_from_camera);
  const int height = rays.height();
  const int blocks = (height + kRowBlock - 1) / kRowBlock;
  std::vector<RayHit> hits(rays.rays().size());
  std::vector<DepthSample> samples(hits.size());
  ParallelFor(blocks, threads, [&](int64_t block) {
    const int first = static_cast<int>(block) * kRowBlock;
    const int last = std::min(first + kRowBlock, height);
    CastRows(view, first, last, hits);
    const size_t width = static_cast<size_t>(rays.width());
    for (size_t i = static_cast<size_t>(first) * width;
         i < static_cast<size_t>(last) * width; ++i) {
      if (hits[i].surface == RayHit::kNothing) continue;
      // Rays have z = 1 in the camera's frame: their length in it is depth.
      const Float3 direction = view.DirectionInWorld(rays.rays()[i]);
      const float cosine = Dot(direction, shadings_[hits[i].surface].normal) *
                           rays.inverse_lengths()[i];
      samples[i] = {hits[i].distance, std::abs(cosine)};
    }
  });
  return samples;
}

}  // namespace treeline
