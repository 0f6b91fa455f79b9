// A furnished living room with a desk, arranged by seed.
#ifndef COMMON_SYNTHETIC_ROOM_H_
#define COMMON_SYNTHETIC_ROOM_H_

#include <cstdint>
#include <optional>
#include <string>

#include "common/synthetic/world.h"

namespace treeline {

// Measures, furniture and pictures follow from the seed; nullopt: of the room
// that is called "room". Paints on up to `threads` threads.
World MakeRoom(std::string name, std::optional<uint64_t> seed, int threads);

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_ROOM_H_
