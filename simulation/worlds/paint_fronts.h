// Painters of fronts of furniture and of things that lie about. See
// paint_materials.h.
#ifndef SIMULATION_WORLDS_PAINT_FRONTS_H_
#define SIMULATION_WORLDS_PAINT_FRONTS_H_

#include <cstdint>

#include "simulation/worlds/canvas.h"
#include "simulation/worlds/float3.h"

namespace treeline::worlds {

// Spines of books: kSpineColumns x kSpineRows of them, each a tile.
inline constexpr int kSpineColumns = 16;
inline constexpr int kSpineRows = 4;
Canvas PaintBookSpines(uint64_t seed);
// A cardboard box with tape, label and print.
Canvas PaintCardboard(uint64_t seed);
// A panelled door.
Canvas PaintDoor(Float3 color, uint64_t seed);
// The front of a cupboard with columns x rows of doors or drawers.
Canvas PaintCupboard(Float3 tone, int columns, int rows, uint64_t seed);
// A computer's screen, its keyboard, and a printed page.
Canvas PaintScreen(uint64_t seed);
Canvas PaintKeyboard(uint64_t seed);
Canvas PaintPage(uint64_t seed);
// A cushion, a magazine's title page, and a clock's face.
Canvas PaintCushion(float hue, uint64_t seed);
Canvas PaintMagazine(uint64_t seed);
Canvas PaintClock(uint64_t seed);

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_PAINT_FRONTS_H_
