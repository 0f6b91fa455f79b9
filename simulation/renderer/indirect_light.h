// Light that comes from surfaces rather than from lamps.
#ifndef SIMULATION_RENDERER_INDIRECT_LIGHT_H_
#define SIMULATION_RENDERER_INDIRECT_LIGHT_H_

#include "simulation/worlds/world.h"

namespace treeline::renderer {

// What a surface gives others by what it reflects of `light`, as a multiple of
// its reflectance. By day also by its emission, though its area light shines
// beside it: worlds were furnished with lamps by that look. In other lights by
// area lights alone: few of the rays that gather light would meet a screen or a
// far window, and leave spots where all else is dark.
worlds::Float3 GivenOn(const worlds::World& world,
                       const worlds::Surface& surface, worlds::Float3 light);

}  // namespace treeline::renderer

#endif  // SIMULATION_RENDERER_INDIRECT_LIGHT_H_
