// How a Segway RMP100 is to be driven.
#ifndef NAV_AGENT_DRIVERS_SEGWAY_SEGWAY_OPTIONS_H_
#define NAV_AGENT_DRIVERS_SEGWAY_SEGWAY_OPTIONS_H_

#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "nav_agent/drivers/segway/segway_codec.h"
#include "nav_agent/drivers/segway/velocity_limits.h"

namespace treeline::segway {

struct SegwayOptions {
  SegwayWire wire{};
  // The channel to listen to, kSegwayChannelA or B; nullopt: the first on which
  // a whole status cycle comes.
  std::optional<uint8_t> receive_channel{};
  VelocityLimits limits{};
  // Between the wheels; only TurnWatch needs it.
  double wheel_track_m = 0.54;

  // What is set when a connection begins.
  SegwayMode mode = SegwayMode::kTractor;
  uint16_t gain_schedule = 0;  // 0 light, 1 tall, 2 heavy
  // Of the base's own limits, in parts of 16, [1, 16]. They hold whatever this
  // driver asks for, and are how hard the base brakes when commands end.
  uint16_t max_velocity_scale = 16;
  uint16_t max_acceleration_scale = 16;
  uint16_t max_turn_scale = 16;
  // In parts of 256, [1, 256].
  uint16_t current_limit_scale = 256;
  // Whether the base's counters are set to zero when the first connection
  // begins. (Readings do not depend on it.)
  bool reset_integrators = true;
  // Whether a base that leaves `mode` by itself, as after its emergency stop,
  // is put into it again. It then still waits for a new command.
  bool restore_mode = true;

  // A frame goes to the base this often. [0.01, 0.1]: the base wants 10 ms to
  // 300 ms.
  double command_interval_s = 0.02;
  // Without a status cycle for this long the base is lost. [0.05, 0.4]
  double link_timeout_s = 0.25;
  // After this long without one the port is opened anew. [0.5, 60]
  double reopen_after_s = 2.0;

  absl::Status Validate() const;
};

}  // namespace treeline::segway

#endif  // NAV_AGENT_DRIVERS_SEGWAY_SEGWAY_OPTIONS_H_
