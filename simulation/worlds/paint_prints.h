// Painters of pictures and of what is outside of windows. See
// paint_materials.h.
#ifndef SIMULATION_WORLDS_PAINT_PRINTS_H_
#define SIMULATION_WORLDS_PAINT_PRINTS_H_

#include <cstdint>

#include "simulation/worlds/canvas.h"

namespace treeline::worlds {

// A framed picture: landscape, abstract, poster, plan or photograph by turns
// of `kind`.
Canvas PaintPicture(int kind, uint64_t seed);
// What is outside the window.
Canvas PaintWindowView(uint64_t seed);

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_PAINT_PRINTS_H_
