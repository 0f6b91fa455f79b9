// Plays a base on a line.
#ifndef NAV_AGENT_EMULATORS_SEGWAY_SERVER_H_
#define NAV_AGENT_EMULATORS_SEGWAY_SERVER_H_

#include <stop_token>

#include "absl/status/status.h"
#include "common/base/clock.h"
#include "nav_agent/drivers/stream/byte_stream.h"
#include "nav_agent/emulators/segway_emulator.h"

namespace treeline {

// Until stop is requested (OK) or the other side is gone (UNAVAILABLE). What
// nobody reads is forgotten, as on a serial line.
absl::Status ServeSegway(SegwayEmulator& emulator, ByteStream& stream,
                         const Clock& clock, const std::stop_token& stop);

}  // namespace treeline

#endif  // NAV_AGENT_EMULATORS_SEGWAY_SERVER_H_
