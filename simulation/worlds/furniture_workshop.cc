#include "simulation/worlds/furniture_workshop.h"

#include <utility>

#include "simulation/worlds/paint_fronts.h"
#include "simulation/worlds/paint_materials.h"

namespace treeline::worlds {

FurnitureWorkshop::FurnitureWorkshop(WorldBuilder& world_builder, uint64_t seed)
    : builder(world_builder), random(seed, 0xf0) {
  const float warmth = Uniform(0.9f, 1.1f);
  dark_wood = Wood({0.40f * warmth, 0.25f, 0.16f});
  light_wood = Wood({0.78f * warmth, 0.62f, 0.43f});
  white = Plain({0.88f, 0.87f, 0.84f});
  black = Plain({0.13f, 0.13f, 0.14f});
  metal = Plain({0.62f, 0.63f, 0.66f});
  paper_edge = Plain({0.90f, 0.87f, 0.78f});
  spines = builder.AddTexture(
      [texture_seed = NextSeed()] { return PaintBookSpines(texture_seed); });
  leaf = builder.AddTexture(
      [texture_seed = NextSeed()] { return PaintLeaf(texture_seed); });
  next_picture = static_cast<int>(random.NextBelow(6));
}

Finish FurnitureWorkshop::Wood(Float3 tone) {
  const uint64_t seed = NextSeed();
  return {.texture = builder.AddTexture(
              [tone, seed] { return PaintWood(tone, seed); }),
          .tile_m = 0.8f};
}

Finish FurnitureWorkshop::Plain(Float3 color) {
  const uint64_t seed = NextSeed();
  return {.texture = builder.AddTexture(
              [color, seed] { return PaintPlain(color, 0.12f, seed); }),
          .tile_m = 0.4f};
}

Finish FurnitureWorkshop::Stretched(std::function<Canvas()> paint,
                                    float emission) {
  return {.texture = builder.AddTexture(std::move(paint)),
          .tile_m = 0,
          .emission = emission};
}

void FurnitureWorkshop::TableLegs(const Placement& at, Float3 low, Float3 high,
                                  float thick_m, const Finish& finish) {
  for (const float x : {low.x, high.x - thick_m}) {
    for (const float y : {low.y, high.y - thick_m}) {
      builder.AddBox(at, {x, y, low.z}, {x + thick_m, y + thick_m, high.z},
                     {.sides = finish});
    }
  }
}

}  // namespace treeline::worlds
