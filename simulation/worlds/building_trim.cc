#include "simulation/worlds/building_trim.h"

#include <utility>

#include "simulation/worlds/paint_materials.h"

namespace treeline::worlds {

BuildingTrim MakeBuildingTrim(WorldBuilder& builder) {
  // In this order: textures are numbered as they come.
  BuildingTrim trim;
  trim.white = PaintedFinish(
      builder,
      [] {
        return PaintPlain({0.90f, 0.89f, 0.86f}, 0.06f, 1);
      },
      0.4f);
  trim.metal = PaintedFinish(
      builder,
      [] {
        return PaintPlain({0.45f, 0.46f, 0.48f}, 0.12f, 2);
      },
      0.4f);
  trim.shine = PaintedFinish(
      builder,
      [] {
        return Canvas(4, 4, {1, 0.97f, 0.92f});
      },
      0, 3);
  return trim;
}

Finish PaintedFinish(WorldBuilder& builder, std::function<Canvas()> paint,
                     float tile_m, float emission) {
  return {.texture = builder.AddTexture(std::move(paint)),
          .tile_m = tile_m,
          .emission = emission};
}

}  // namespace treeline::worlds
