// Painters of materials for large surfaces: pictures without a seam, which
// repeat after as many metres as stated. See paint_materials.h.
#ifndef SIMULATION_WORLDS_PAINT_BUILDING_H_
#define SIMULATION_WORLDS_PAINT_BUILDING_H_

#include <cstdint>

#include "simulation/worlds/canvas.h"
#include "simulation/worlds/float3.h"

namespace treeline::worlds {

// Walls: 5 m x 2.5 m.
Canvas PaintPlasterWall(Float3 color, uint64_t seed);
Canvas PaintPaperWall(Float3 color, uint64_t seed);
Canvas PaintBrickWall(Float3 color, uint64_t seed);
Canvas PaintConcreteWall(Float3 color, uint64_t seed);
// Blots of all sizes, for who wants texture and nothing else.
Canvas PaintBlots(Float3 color, uint64_t seed);
// Floors: 5 m x 5 m.
Canvas PaintPlankFloor(Float3 color, uint64_t seed);
Canvas PaintTileFloor(Float3 color, uint64_t seed);
Canvas PaintCarpetFloor(Float3 color, uint64_t seed);
// Studded rubber, 1 m x 1 m.
Canvas PaintRubberFloor(Float3 color, uint64_t seed);
// A person's clothes, and a trolley's load.
Canvas PaintClothes(float hue, uint64_t seed);

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_PAINT_BUILDING_H_
