// A furnished living room with a desk, arranged by seed.
#ifndef SIMULATION_WORLDS_ROOM_H_
#define SIMULATION_WORLDS_ROOM_H_

#include <cstdint>
#include <optional>
#include <string>

#include "simulation/worlds/world.h"

namespace treeline::worlds {

// Measures, furniture and pictures follow from the seed; nullopt: of the room
// that is called "room". Paints on up to `threads` threads.
World MakeRoom(std::string name, std::optional<uint64_t> seed, int threads);

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_ROOM_H_
