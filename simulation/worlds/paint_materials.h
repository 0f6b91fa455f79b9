// Painters of materials. Each returns a picture whose sides are
// powers of two, as Texture needs them, and which depends on its arguments
// alone.
#ifndef SIMULATION_WORLDS_PAINT_MATERIALS_H_
#define SIMULATION_WORLDS_PAINT_MATERIALS_H_

#include <cstdint>

#include "simulation/worlds/canvas.h"
#include "simulation/worlds/float3.h"

namespace treeline::worlds {

// A colour by hue (turns), saturation and brightness (both in [0, 1]). An
// aggregate, because its members are evaluated in order, as function arguments
// are not: random draws must not depend on the compiler.
struct HsvColor {
  float hue = 0;
  float saturation = 0;
  float value = 0;
};
Float3 Hsv(HsvColor color);

// Almost flat colour with grain. Tiles.
Canvas PaintPlain(Float3 color, float grain, uint64_t seed);
// Rolled wall paint, with the stains of years. 5 m x 2.6 m.
Canvas PaintPlaster(Float3 color, uint64_t seed);
// Stripes with a repeated blossom. 5 m x 2.6 m.
Canvas PaintWallpaper(float hue, uint64_t seed);
// Bare bricks in stretcher bond. 5 m x 2.6 m.
Canvas PaintBrick(uint64_t seed);
// Floor boards along u. 5 m x 4 m.
Canvas PaintPlanks(uint64_t seed);
// Sawn wood, grain along u. Tiles at 0.8 m.
Canvas PaintWood(Float3 tone, uint64_t seed);
// Woven cloth. Tiles at 0.5 m.
Canvas PaintFabric(Float3 color, uint64_t seed);
// A patterned carpet with a border.
Canvas PaintRug(float hue, uint64_t seed);
// Cloth in folds along v.
Canvas PaintCurtain(float hue, uint64_t seed);
// A white radiator's ribs.
Canvas PaintRadiator(uint64_t seed);
// A leaf of a house plant.
Canvas PaintLeaf(uint64_t seed);

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_PAINT_MATERIALS_H_
