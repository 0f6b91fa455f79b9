#include "simulation/renderer/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "common/base/parallel_for.h"
#include "common/base/status_macros.h"

namespace treeline::renderer {
namespace {

// Rows that one thread takes at a time.
constexpr int kRowBlock = 16;
// Rays are cast by the tile: 32 that look nearly the same way.
constexpr int kTileWidth = 8;
constexpr int kTileHeight = 4;
constexpr size_t kTile = kTileWidth * kTileHeight;

// A pane of window glass: light that goes through it straight on, and the
// share that both of its faces reflect then.
constexpr worlds::Float3 kGlassTint = {0.90f, 0.94f, 0.92f};
constexpr float kGlassReflection = 0.08f;
// Of the light around, what a mirror shows of it: lamps are small.
constexpr float kMirrored = 0.4f;

// How far from a body the ground is darker, and how much at most.
constexpr float kShadowReach_m = 0.3f;
constexpr float kShadowDepth = 0.45f;

worlds::Float3 ToFloat3(geometry::Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y),
          static_cast<float>(v.z)};
}

// A body where it stands in a view.
struct PlacedBody {
  size_t body = 0;
  worlds::Float3 origin;
  worlds::Float3 x_axis;
  worlds::Float3 y_axis;
  worlds::Float3 scale;

  worlds::Float3 Normal(worlds::Float3 in_body) const {
    return Normalized((in_body.x / scale.x) * x_axis +
                      (in_body.y / scale.y) * y_axis +
                      worlds::Float3{0, 0, in_body.z / scale.z});
  }
  worlds::Float3 PointInBody(worlds::Float3 point) const {
    const worlds::Float3 way = point - origin;
    return {Dot(way, x_axis) / scale.x, Dot(way, y_axis) / scale.y,
            way.z / scale.z};
  }
};

PlacedBody Place(const worlds::BodyInstance& instance) {
  const worlds::Placement& at = instance.world_from_body;
  return {.body = static_cast<size_t>(instance.body),
          .origin = at.origin,
          .x_axis = at.Direction({1, 0, 0}),
          .y_axis = at.Direction({0, 1, 0}),
          .scale = instance.scale};
}

// The light that is left on ground near something that stands between `low`
// and `high` (all in its frame).
float LeftNear(worlds::Float3 ground, worlds::Float3 low, worlds::Float3 high) {
  if (std::abs(ground.z) > kShadowReach_m) return 1;
  const float x = std::max({low.x - ground.x, ground.x - high.x, 0.0f});
  const float y = std::max({low.y - ground.y, ground.y - high.y, 0.0f});
  const float near = 1 - std::sqrt(x * x + y * y) / kShadowReach_m;
  return near > 0 ? 1 - kShadowDepth * near * near : 1;
}

// Calls body(first, last) for blocks of rows, in parallel.
void ForRows(int height, int threads,
             const std::function<void(int, int)>& body) {
  const int blocks = (height + kRowBlock - 1) / kRowBlock;
  base::ParallelFor(blocks, threads, [&](int64_t block) {
    const int first = static_cast<int>(block) * kRowBlock;
    body(first, std::min(first + kRowBlock, height));
  });
}

}  // namespace

PixelRays::PixelRays(const camera::Camera& camera)
    : width_(camera.width()),
      height_(camera.height()),
      focal_length_px_(static_cast<float>((camera.fx() + camera.fy()) / 2)) {
  const size_t count =
      static_cast<size_t>(width_) * static_cast<size_t>(height_);
  rays_.reserve(count);
  inverse_lengths_.reserve(count);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const std::optional<camera::Pixel> ray =
          camera.Unproject({1.0 * x, 1.0 * y});
      const worlds::Float3 direction = ray.has_value()
                                           ? ToFloat3({ray->x, ray->y, 1})
                                           : worlds::Float3{0, 0, 0};
      rays_.push_back(direction);
      inverse_lengths_.push_back(direction.z > 0 ? 1 / Norm(direction) : 0);
    }
  }
}

struct Renderer::View {
  View(const WorldSnapshot& world_snapshot, const PixelRays& pixel_rays,
       const geometry::Rigid3& world_from_camera)
      : snapshot(world_snapshot),
        rays(pixel_rays),
        origin(ToFloat3(world_from_camera.translation)) {
    const geometry::Mat3 matrix = world_from_camera.rotation.Matrix();
    x_axis = ToFloat3({matrix(0, 0), matrix(1, 0), matrix(2, 0)});
    y_axis = ToFloat3({matrix(0, 1), matrix(1, 1), matrix(2, 1)});
    z_axis = ToFloat3({matrix(0, 2), matrix(1, 2), matrix(2, 2)});
    for (const worlds::BodyInstance& instance : snapshot.instances()) {
      bodies.push_back(Place(instance));
    }
  }

  worlds::Float3 DirectionInWorld(worlds::Float3 ray) const {
    return ray.x * x_axis + ray.y * y_axis + ray.z * z_axis;
  }
  worlds::Float3 DirectionInCamera(worlds::Float3 way) const {
    return {Dot(way, x_axis), Dot(way, y_axis), Dot(way, z_axis)};
  }

  const WorldSnapshot& snapshot;
  const PixelRays& rays;
  worlds::Float3 origin;
  // The camera's axes in the world.
  worlds::Float3 x_axis;
  worlds::Float3 y_axis;
  worlds::Float3 z_axis;
  // One for each of the snapshot's instances.
  std::vector<PlacedBody> bodies;
};

absl::StatusOr<std::unique_ptr<const Renderer>> Renderer::Create(
    worlds::World world, int threads) {
  return CreateLit(std::move(world), threads);
}

absl::StatusOr<std::unique_ptr<const Renderer>> Renderer::CreateOpened(
    worlds::World world, float cut_m, int threads) {
  TL_ASSIGN_OR_RETURN(std::unique_ptr<Renderer> renderer,
                      CreateLit(std::move(world), threads));
  TL_ASSIGN_OR_RETURN(
      renderer->caster_,
      RayCaster::CreateWithout(
          renderer->world_, [cut_m](const worlds::Surface& surface) {
            float low_m = surface.corners[0].z;
            for (const worlds::Float3& corner : surface.corners) {
              low_m = std::min(low_m, corner.z);
            }
            return surface.kind == worlds::SurfaceKind::kCeiling ||
                   low_m > cut_m;
          }));
  return renderer;
}

absl::StatusOr<std::unique_ptr<Renderer>> Renderer::CreateLit(
    worlds::World world, int threads) {
  TL_ASSIGN_OR_RETURN(RayCaster caster, RayCaster::Create(world));
  LightMap light_map = LightMap::Bake(world, caster, threads);
  LightVolume volume;
  // Only bodies and glass are lit by it.
  if (!world.bodies.empty() || caster.has_glass()) {
    volume = LightVolume::Bake(world, caster, light_map, threads);
  }
  return std::unique_ptr<Renderer>(
      new Renderer(std::move(world), std::move(caster), std::move(light_map),
                   std::move(volume)));
}

absl::StatusOr<std::unique_ptr<const Renderer>> Renderer::CreateUnlit(
    worlds::World world) {
  TL_ASSIGN_OR_RETURN(RayCaster caster, RayCaster::Create(world));
  LightMap light_map = LightMap::Even(world);
  return std::unique_ptr<const Renderer>(
      new Renderer(std::move(world), std::move(caster), std::move(light_map),
                   LightVolume::Even()));
}

Renderer::Renderer(worlds::World world, RayCaster caster, LightMap light_map,
                   LightVolume light_volume)
    : world_(std::move(world)),
      caster_(std::move(caster)),
      light_map_(std::move(light_map)),
      light_volume_(std::move(light_volume)) {
  shadings_.reserve(world_.surfaces.size());
  for (const worlds::Surface& surface : world_.surfaces) {
    shadings_.push_back(ShadingOf(surface));
  }
  for (const worlds::Body& body : world_.bodies) {
    BodyShading shading;
    if (!body.surfaces.empty()) {
      shading.low = shading.high = body.surfaces[0].corners[0];
    }
    for (const worlds::Surface& surface : body.surfaces) {
      shading.surfaces.push_back(ShadingOf(surface));
      for (const worlds::Float3& p : surface.corners) {
        worlds::Float3& low = shading.low;
        worlds::Float3& high = shading.high;
        low = {std::min(low.x, p.x), std::min(low.y, p.y),
               std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y),
                std::max(high.z, p.z)};
      }
    }
    bodies_.push_back(std::move(shading));
  }
}

Renderer::Shading Renderer::ShadingOf(const worlds::Surface& surface) const {
  const worlds::Texture& texture =
      world_.textures[static_cast<size_t>(surface.texture)];
  const auto texels = [&](const std::array<float, 2>& step) {
    return std::hypot(step[0] * static_cast<float>(texture.width()),
                      step[1] * static_cast<float>(texture.height()));
  };
  return {
      .normal = surface.Normal(),
      .texels_per_m = std::max(texels(surface.texture_u) / surface.LengthU(),
                               texels(surface.texture_v) / surface.LengthV())};
}

Renderer::Sight Renderer::MakeSight(const PixelRays& rays) const {
  Sight sight;
  sight.hits.resize(rays.rays().size());
  if (caster_.has_glass()) sight.panes.resize(rays.rays().size());
  return sight;
}

void Renderer::CastRays(const View& view,
                        std::span<const worlds::Float3> directions,
                        std::span<RayHit> hits, std::span<RayHit> panes) const {
  view.snapshot.CastMany(view.origin, directions, hits);
  if (panes.empty()) return;
  caster_.CastManyAtGlass(view.origin, directions, panes);
  for (size_t i = 0; i < panes.size(); ++i) {
    const bool is_hidden = hits[i].surface != RayHit::kNothing &&
                           panes[i].distance >= hits[i].distance;
    if (is_hidden) panes[i] = RayHit();
  }
}

void Renderer::CastRows(const View& view, int first_row, int last_row,
                        Sight& sight) const {
  const int width = view.rays.width();
  const bool has_glass = !sight.panes.empty();
  std::array<worlds::Float3, kTile> directions;
  std::array<RayHit, kTile> hits;
  std::array<RayHit, kTile> panes;
  std::array<size_t, kTile> pixels;
  for (int top = first_row; top < last_row; top += kTileHeight) {
    const int bottom = std::min(top + kTileHeight, last_row);
    for (int left = 0; left < width; left += kTileWidth) {
      const int right = std::min(left + kTileWidth, width);
      size_t count = 0;
      for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x) {
          const size_t pixel =
              static_cast<size_t>(y) * static_cast<size_t>(width) +
              static_cast<size_t>(x);
          const worlds::Float3 ray = view.rays.rays()[pixel];
          pixels[count] = pixel;
          directions[count++] =
              view.DirectionInWorld(ray.z > 0 ? ray : worlds::Float3{0, 0, 1});
        }
      }
      CastRays(view, {directions.data(), count}, {hits.data(), count},
               {panes.data(), has_glass ? count : 0});
      for (size_t i = 0; i < count; ++i) {
        if (!(view.rays.rays()[pixels[i]].z > 0)) continue;
        sight.hits[pixels[i]] = hits[i];
        if (has_glass) sight.panes[pixels[i]] = panes[i];
      }
    }
  }
}

worlds::Float3 Renderer::NormalAt(const View& view, const RayHit& hit) const {
  if (hit.instance == RayHit::kFixed) return shadings_[hit.surface].normal;
  const PlacedBody& placed = view.bodies[static_cast<size_t>(hit.instance)];
  return placed.Normal(bodies_[placed.body].surfaces[hit.surface].normal);
}

worlds::Float3 Renderer::Shade(const View& view, worlds::Float3 direction,
                               float inverse_length, const RayHit& hit) const {
  if (hit.surface == RayHit::kNothing) return {};
  const bool is_fixed = hit.instance == RayHit::kFixed;
  const size_t body =
      is_fixed ? 0 : view.bodies[static_cast<size_t>(hit.instance)].body;
  const worlds::Surface& surface =
      is_fixed ? world_.surfaces[hit.surface]
               : world_.bodies[body].surfaces[hit.surface];
  const worlds::Float3 normal = NormalAt(view, hit);
  const float texels_per_m =
      is_fixed ? shadings_[hit.surface].texels_per_m
               : bodies_[body].surfaces[hit.surface].texels_per_m;
  // A pixel covers distance / f on a surface that faces the camera, more on a
  // slanted one; the root of the slant is a compromise between blur and
  // flicker.
  const float cosine = Dot(direction, normal);
  const float incidence = std::abs(cosine) * inverse_length;
  const float texels =
      hit.distance * texels_per_m / view.rays.focal_length_px();
  const float squared_texels = texels * texels / std::max(incidence, 0.02f);
  const float s = surface.texture_origin[0] + hit.u * surface.texture_u[0] +
                  hit.v * surface.texture_v[0];
  const float t = surface.texture_origin[1] + hit.u * surface.texture_u[1] +
                  hit.v * surface.texture_v[1];
  const worlds::Float3 reflectance =
      world_.textures[static_cast<size_t>(surface.texture)].Sample(
          s, t, squared_texels);
  worlds::Float3 light;
  if (is_fixed) {
    light = light_map_.At(hit.surface, hit.u, hit.v);
    if (!view.bodies.empty() && normal.z > 0.7f) {
      const worlds::Float3 ground = view.origin + hit.distance * direction;
      for (const PlacedBody& placed : view.bodies) {
        const BodyShading& shape = bodies_[placed.body];
        light =
            LeftNear(placed.PointInBody(ground), shape.low, shape.high) * light;
      }
    }
  } else {
    // Of the side that is seen.
    light = light_volume_.At(view.origin + hit.distance * direction,
                             cosine > 0 ? -1 * normal : normal);
  }
  return reflectance * surface.Leaving(light);
}

worlds::Float3 Renderer::ShadeThrough(const View& view,
                                      worlds::Float3 direction,
                                      float inverse_length, const RayHit& pane,
                                      worlds::Float3 behind) const {
  if (pane.surface == RayHit::kNothing) return behind;
  const worlds::Float3 normal = NormalAt(view, pane);
  const worlds::Float3 unit = inverse_length * direction;
  const float cosine = Dot(unit, normal);
  // Schlick's approximation; the reflection is of the light all around where
  // it goes, as from glass that is not quite clean.
  const float slant = 1 - std::min(std::abs(cosine), 1.0f);
  const float squared = slant * slant;
  const float share =
      kGlassReflection + (1 - kGlassReflection) * squared * squared * slant;
  const worlds::Float3 mirrored = unit - 2 * cosine * normal;
  const worlds::Float3 around =
      light_volume_.At(view.origin + pane.distance * direction, mirrored);
  return (1 - share) * kGlassTint * behind + (share * kMirrored) * around;
}

void Renderer::ShadeEdges(const View& view, const std::vector<size_t>& edges,
                          std::vector<worlds::Float3>& radiance) const {
  // On a slanted line through the middle, whose ray is there already; the
  // slant alternates, so that no direction of edges is left jagged.
  constexpr float kAcross_px = 0.33f;
  constexpr float kDown_px = 0.17f;
  const float pixel_size = 1 / view.rays.focal_length_px();
  const size_t width = static_cast<size_t>(view.rays.width());
  std::vector<worlds::Float3> directions;
  directions.reserve(2 * edges.size());
  for (const size_t pixel : edges) {
    const worlds::Float3 ray = view.rays.rays()[pixel];
    const bool is_rising = (pixel % width + pixel / width) % 2 == 0;
    const float x = pixel_size * (is_rising ? kAcross_px : kDown_px);
    const float y = pixel_size * (is_rising ? -kDown_px : kAcross_px);
    directions.push_back(view.DirectionInWorld({ray.x + x, ray.y + y, 1}));
    directions.push_back(view.DirectionInWorld({ray.x - x, ray.y - y, 1}));
  }
  std::vector<RayHit> hits(directions.size());
  std::vector<RayHit> panes(caster_.has_glass() ? directions.size() : 0);
  CastRays(view, directions, hits, panes);
  for (size_t i = 0; i < edges.size(); ++i) {
    const float inverse_length = view.rays.inverse_lengths()[edges[i]];
    worlds::Float3 sum = radiance[edges[i]];
    for (size_t k = 2 * i; k < 2 * i + 2; ++k) {
      worlds::Float3 shade =
          Shade(view, directions[k], inverse_length, hits[k]);
      if (!panes.empty()) {
        shade =
            ShadeThrough(view, directions[k], inverse_length, panes[k], shade);
      }
      sum = sum + shade;
    }
    radiance[edges[i]] = (1.0f / 3) * sum;
  }
}

std::vector<worlds::Float3> Renderer::RenderRadiance(
    const PixelRays& rays, const geometry::Rigid3& world_from_camera,
    int threads) const {
  return RenderRadiance(caster_.At({}), rays, world_from_camera, threads);
}

std::vector<DepthSample> Renderer::RenderDepth(
    const PixelRays& rays, const geometry::Rigid3& world_from_camera,
    int threads) const {
  return RenderDepth(caster_.At({}), rays, world_from_camera, threads);
}

std::vector<worlds::Float3> Renderer::RenderRadiance(
    const WorldSnapshot& snapshot, const PixelRays& rays,
    const geometry::Rigid3& world_from_camera, int threads) const {
  const View view(snapshot, rays, world_from_camera);
  const int height = rays.height();
  const size_t width = static_cast<size_t>(rays.width());
  Sight sight = MakeSight(rays);
  ForRows(height, threads,
          [&](int first, int last) { CastRows(view, first, last, sight); });
  const std::vector<RayHit>& hits = sight.hits;
  const bool has_glass = !sight.panes.empty();
  std::vector<worlds::Float3> radiance(hits.size());
  const size_t last_row = hits.size() - width;
  const auto differ = [&](size_t i, size_t k) {
    return hits[i].surface != hits[k].surface ||
           hits[i].instance != hits[k].instance ||
           (has_glass && sight.panes[i].surface != sight.panes[k].surface);
  };
  ForRows(height, threads, [&](int first, int last) {
    std::vector<size_t> edges;
    for (size_t i = static_cast<size_t>(first) * width;
         i < static_cast<size_t>(last) * width; ++i) {
      if (!(rays.rays()[i].z > 0)) continue;
      const size_t x = i % width;
      if ((x > 0 && differ(i, i - 1)) || (x + 1 < width && differ(i, i + 1)) ||
          (i >= width && differ(i, i - width)) ||
          (i < last_row && differ(i, i + width))) {
        edges.push_back(i);
      }
      const worlds::Float3 direction = view.DirectionInWorld(rays.rays()[i]);
      const float inverse_length = rays.inverse_lengths()[i];
      radiance[i] = Shade(view, direction, inverse_length, hits[i]);
      if (has_glass) {
        radiance[i] = ShadeThrough(view, direction, inverse_length,
                                   sight.panes[i], radiance[i]);
      }
    }
    ShadeEdges(view, edges, radiance);
  });
  return radiance;
}

std::vector<DepthSample> Renderer::RenderDepth(
    const WorldSnapshot& snapshot, const PixelRays& rays,
    const geometry::Rigid3& world_from_camera, int threads) const {
  const View view(snapshot, rays, world_from_camera);
  const size_t width = static_cast<size_t>(rays.width());
  Sight sight = MakeSight(rays);
  std::vector<DepthSample> samples(sight.hits.size());
  ForRows(rays.height(), threads, [&](int first, int last) {
    CastRows(view, first, last, sight);
    for (size_t i = static_cast<size_t>(first) * width;
         i < static_cast<size_t>(last) * width; ++i) {
      const RayHit& hit = sight.hits[i];
      if (hit.surface == RayHit::kNothing) continue;
      // Rays have z = 1 in the camera's frame: their length in it is depth.
      const worlds::Float3 direction = view.DirectionInWorld(rays.rays()[i]);
      const float cosine =
          Dot(direction, NormalAt(view, hit)) * rays.inverse_lengths()[i];
      samples[i] = {
          hit.distance, std::abs(cosine),
          !sight.panes.empty() && sight.panes[i].surface != RayHit::kNothing};
    }
  });
  return samples;
}

std::vector<PixelTruth> Renderer::RenderTruth(
    const WorldSnapshot& snapshot, const PixelRays& rays,
    const geometry::Rigid3& world_from_camera, int threads) const {
  const View view(snapshot, rays, world_from_camera);
  const size_t width = static_cast<size_t>(rays.width());
  Sight sight = MakeSight(rays);
  std::vector<PixelTruth> truth(sight.hits.size());
  ForRows(rays.height(), threads, [&](int first, int last) {
    CastRows(view, first, last, sight);
    for (size_t i = static_cast<size_t>(first) * width;
         i < static_cast<size_t>(last) * width; ++i) {
      const RayHit& hit = sight.hits[i];
      if (hit.surface == RayHit::kNothing) continue;
      const worlds::Float3 normal = NormalAt(view, hit);
      const bool is_back =
          Dot(view.DirectionInWorld(rays.rays()[i]), normal) > 0;
      const std::vector<worlds::Surface>& surfaces =
          hit.instance == RayHit::kFixed
              ? world_.surfaces
              : world_
                    .bodies[view.bodies[static_cast<size_t>(hit.instance)].body]
                    .surfaces;
      truth[i] = {
          .surface = hit.surface,
          .instance = hit.instance,
          .kind = surfaces[hit.surface].kind,
          .depth_m = hit.distance,
          .normal_in_camera =
              view.DirectionInCamera(is_back ? -1 * normal : normal),
          .is_behind_glass = !sight.panes.empty() &&
                             sight.panes[i].surface != RayHit::kNothing};
    }
  });
  return truth;
}

}  // namespace treeline::renderer
