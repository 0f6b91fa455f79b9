#include "simulation/worlds/world_builder.h"

#include <cstddef>
#include <map>
#include <optional>
#include <utility>

#include "common/base/parallel_for.h"
#include "simulation/worlds/noise.h"

namespace treeline::worlds {
namespace {

constexpr float kViewLift_m = 0.004f;

}  // namespace

int WorldBuilder::AddTexture(std::function<Canvas()> paint) {
  painters_.push_back(std::move(paint));
  return static_cast<int>(painters_.size()) - 1;
}

void WorldBuilder::AddSurface(const std::array<Float3, 4>& corners,
                              const Finish& finish) {
  Surface surface{.corners = corners, .texture = finish.texture};
  surface.kind = kind_;
  surface.emission = {finish.emission, finish.emission, finish.emission};
  if (finish.emission > 0) surface.source = source_;
  if (finish.tile_m > 0) {
    // Each surface is cut from another place of the material, with the grain
    // along its longer side.
    const int index = static_cast<int>(surfaces_.size());
    surface.texture_origin = {CellNoise(index, 0, 1), CellNoise(index, 1, 1)};
    const float u = surface.LengthU() / finish.tile_m;
    const float v = surface.LengthV() / finish.tile_m;
    const bool along_u = u >= v;
    surface.texture_u = {along_u ? u : 0, along_u ? 0 : u};
    surface.texture_v = {along_u ? 0 : v, along_u ? v : 0};
  } else {
    surface.texture_origin = {finish.u0, finish.v0};
    surface.texture_u = {finish.u1 - finish.u0, 0};
    surface.texture_v = {0, finish.v1 - finish.v0};
  }
  surfaces_.push_back(surface);
}

void WorldBuilder::AddQuad(const Placement& placement,
                           const std::array<Float3, 4>& corners,
                           const Finish& finish) {
  AddSurface({placement.Point(corners[0]), placement.Point(corners[1]),
              placement.Point(corners[2]), placement.Point(corners[3])},
             finish);
}

void WorldBuilder::AddPanel(const Placement& placement, Float3 top_left,
                            Float3 right, Float3 down, const Finish& finish) {
  AddQuad(
      placement,
      {top_left, top_left + right, top_left + right + down, top_left + down},
      finish);
}

void WorldBuilder::AddLight(AreaLight light) {
  light.source = source_;
  lights_.push_back(light);
}

void WorldBuilder::AddView(const Placement& wall, Float3 top_left, Float3 right,
                           Float3 down, Float3 sky_radiance,
                           const Finish& finish) {
  source_ = kSky;
  const auto before = [&](float lift_m) {
    return Float3{top_left.x, lift_m, top_left.z};
  };
  AddPanel(wall, before(kViewLift_m), right, down, finish);
  AddLight({.corner = wall.Point(before(kViewLift_m + kSkyBeforeView_m)),
            .edge_u = wall.Direction(right),
            .edge_v = down,
            .radiance = sky_radiance});
  source_ = kNoLamp;
}

void WorldBuilder::AddBox(const Placement& placement, Float3 low, Float3 high,
                          const BoxFinish& finish) {
  const float w = high.x - low.x;
  const float d = high.y - low.y;
  const float h = high.z - low.z;
  const Finish& sides = finish.sides;
  AddPanel(placement, high, {-w, 0, 0}, {0, 0, -h},
           finish.front.value_or(sides));
  AddPanel(placement, {low.x, low.y, high.z}, {w, 0, 0}, {0, 0, -h}, sides);
  AddPanel(placement, {high.x, low.y, high.z}, {0, d, 0}, {0, 0, -h}, sides);
  AddPanel(placement, {low.x, high.y, high.z}, {0, -d, 0}, {0, 0, -h}, sides);
  AddPanel(placement, {high.x, low.y, high.z}, {-w, 0, 0}, {0, d, 0},
           finish.top.value_or(sides));
  if (finish.has_bottom) {
    AddPanel(placement, low, {w, 0, 0}, {0, d, 0}, sides);
  }
}

void WorldBuilder::AddTurned(const Placement& placement, Float3 base,
                             std::span<const ProfilePoint> profile,
                             int segments, const Finish& finish) {
  const auto point = [&](const ProfilePoint& p, int i) {
    const float angle =
        6.2831853f * static_cast<float>(i) / static_cast<float>(segments);
    return placement.Point(base + Float3{p.radius_m * std::cos(angle),
                                         p.radius_m * std::sin(angle),
                                         p.height_m});
  };
  for (size_t ring = 1; ring < profile.size(); ++ring) {
    const ProfilePoint& lower = profile[ring - 1];
    const ProfilePoint& upper = profile[ring];
    for (int i = 0; i < segments; ++i) {
      Finish part = finish;
      if (finish.tile_m <= 0) {
        const float step =
            (finish.u1 - finish.u0) / static_cast<float>(segments);
        part.u0 = finish.u0 + step * static_cast<float>(i);
        part.u1 = part.u0 + step;
      }
      // Seen from outside, the angle grows to the right.
      AddSurface({point(upper, i), point(upper, i + 1), point(lower, i + 1),
                  point(lower, i)},
                 part);
    }
  }
}

void WorldBuilder::BeginBody() { body_begin_ = surfaces_.size(); }

int WorldBuilder::EndBody(std::string name, float radius_m, float height_m,
                          std::optional<Motion> motion) {
  const auto begin =
      surfaces_.begin() + static_cast<std::ptrdiff_t>(body_begin_.value());
  bodies_.push_back({.name = std::move(name),
                     .surfaces = {begin, surfaces_.end()},
                     .radius_m = radius_m,
                     .height_m = height_m,
                     .motion = std::move(motion)});
  surfaces_.erase(begin, surfaces_.end());
  body_begin_.reset();
  return static_cast<int>(bodies_.size()) - 1;
}

void WorldBuilder::BeginPiece() {
  pieces_.push_back(
      {.first_surface = surfaces_.size(), .first_light = lights_.size()});
}

void WorldBuilder::EndPiece() {
  Piece& piece = pieces_.back();
  piece.surface_count = surfaces_.size() - piece.first_surface;
  piece.light_count = lights_.size() - piece.first_light;
}

void WorldBuilder::BeginGroup() {
  group_begin_ = surfaces_.size();
  group_lights_begin_ = lights_.size();
}

WorldBuilder::Group WorldBuilder::EndGroup() {
  const auto begin =
      surfaces_.begin() + static_cast<std::ptrdiff_t>(group_begin_);
  const auto lights_begin =
      lights_.begin() + static_cast<std::ptrdiff_t>(group_lights_begin_);
  Group group = {.surfaces = {begin, surfaces_.end()},
                 .lights = {lights_begin, lights_.end()}};
  surfaces_.erase(begin, surfaces_.end());
  lights_.erase(lights_begin, lights_.end());
  return group;
}

void WorldBuilder::AddGroup(const Group& group, const Placement& placement) {
  std::map<int, int> lamps;
  const auto own = [&](int source) {
    if (source < 0) return source;
    const auto [it, is_new] = lamps.try_emplace(source, next_lamp_);
    if (is_new) ++next_lamp_;
    return it->second;
  };
  for (Surface surface : group.surfaces) {
    for (Float3& corner : surface.corners) corner = placement.Point(corner);
    surface.source = own(surface.source);
    surfaces_.push_back(surface);
  }
  for (AreaLight light : group.lights) {
    light.corner = placement.Point(light.corner);
    light.edge_u = placement.Direction(light.edge_u);
    light.edge_v = placement.Direction(light.edge_v);
    light.source = own(light.source);
    lights_.push_back(light);
  }
}

World WorldBuilder::Build(std::string name, Float3 size_m,
                          const WalkArea& walk_area, int threads) {
  std::vector<std::optional<Texture>> painted(painters_.size());
  base::ParallelFor(
      static_cast<int64_t>(painters_.size()), threads, [&](int64_t i) {
        const size_t index = static_cast<size_t>(i);
        painted[index].emplace(paint_ ? painters_[index]()
                                      : Canvas(1, 1, {0.5f, 0.5f, 0.5f}));
      });
  World world;
  world.name = std::move(name);
  world.size_m = size_m;
  world.walk_area = walk_area;
  world.textures.reserve(painted.size());
  for (std::optional<Texture>& texture : painted) {
    world.textures.push_back(*std::move(texture));
  }
  world.surfaces = std::move(surfaces_);
  world.lights = std::move(lights_);
  world.pieces = std::move(pieces_);
  world.bodies = std::move(bodies_);
  return world;
}

}  // namespace treeline::worlds
