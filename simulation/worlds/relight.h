// The same world in another light.
#ifndef SIMULATION_WORLDS_RELIGHT_H_
#define SIMULATION_WORLDS_RELIGHT_H_

#include "simulation/worlds/world.h"

namespace treeline::worlds {

// Puts a world as it was built, which is by day, into this light: lamps and
// windows get another colour and brightness, some lamps go out, and the sun
// gets its beams. The sun stands where most of the windows see it, 32 degrees
// high. Screens get lights of their own. Which lamps go out follows from their
// numbers alone. kDay changes nothing. docs/reference/worlds.md describes the
// lights.
void Relight(building::Lighting lighting, World& world);

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_RELIGHT_H_
