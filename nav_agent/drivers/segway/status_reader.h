// Makes readings of the base's status messages.
#ifndef NAV_AGENT_DRIVERS_SEGWAY_STATUS_READER_H_
#define NAV_AGENT_DRIVERS_SEGWAY_STATUS_READER_H_

#include <array>
#include <cstdint>
#include <optional>

#include "common/base/clock.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/drivers/segway/segway_codec.h"

namespace treeline::segway {

// Assembles status cycles, stamps them and counts the wheels on.
//
// * A cycle counts only if its eight messages came complete and in order on one
//   channel. Where both channels carry cycles, the first to complete one is
//   kept to until Reconnected().
// * Stamps are the base's own count of 0.01 s, put on our clock by the quickest
//   arrival of the last second or two: what a read waits in buffers does not
//   move them. They never run backwards, and are never after the arrival.
// * The readings' wheels never jump: they go on through the wrapping of 32-bit
//   counters, through gaps, and where the base was restarted or its counters
//   were reset they go on from where they were, without what was rolled
//   meanwhile. A cycle that contradicts the one before is left out and counted;
//   if the next agrees with it, the base was restarted.
class SegwayStatusReader {
 public:
  // channel: to heed alone; nullopt: the first on which a cycle completes.
  SegwayStatusReader(const SegwayWire& wire, std::optional<uint8_t> channel);

  // After a new connection.
  void Reconnected();
  // The base's counters are about to be reset, or have been.
  void CountersReset();

  // A reading, if this message completes one. Its motors_enabled is true.
  std::optional<core::BaseReading> Take(const SegwayMessage& message,
                                        base::MonotonicTime arrival);

  // The last cycle that made a reading.
  const std::optional<SegwayCycle>& last_cycle() const { return last_cycle_; }
  std::optional<uint8_t> channel() const { return channel_; }
  int64_t incomplete_cycles() const { return incomplete_; }
  int64_t implausible_cycles() const { return implausible_; }

 private:
  static constexpr int kSkipping = -1;
  struct Assembly {
    SegwayCycle cycle;
    // How many messages of the cycle have come; kSkipping: it has a gap or
    // began before the connection, and the rest of it is of no use.
    int messages = kSkipping;
  };
  struct Timed {
    SegwayCycle cycle;
    base::MonotonicTime arrival;
    // The base's clock, unwrapped.
    int64_t device_frames = 0;
  };

  std::optional<SegwayCycle> Assemble(const SegwayMessage& message);
  std::optional<core::BaseReading> Accept(const SegwayCycle& cycle,
                                          base::MonotonicTime arrival);
  // Puts `now` after `before` on the base's clock; nullopt if it cannot come
  // after it.
  static std::optional<int64_t> FramesBetween(const Timed& before,
                                              const SegwayCycle& cycle,
                                              base::MonotonicTime arrival);
  static bool WheelsCanHaveRolled(const SegwayCycle& before,
                                  const SegwayCycle& after, int64_t frames);
  void BeginAt(const SegwayCycle& cycle, base::MonotonicTime arrival);
  base::MonotonicTime StampOf(const Timed& timed);

  const SegwayWire wire_;
  const std::optional<uint8_t> only_channel_;
  std::optional<uint8_t> channel_;
  std::array<Assembly, 2> assemblies_;
  int64_t incomplete_ = 0;
  int64_t implausible_ = 0;

  std::optional<SegwayCycle> last_cycle_;
  std::optional<Timed> last_;
  std::optional<Timed> suspect_;
  bool recount_ = false;
  // Our clock less the base's (ns): the least since window_begin_, and of the
  // window before.
  int64_t min_offset_ns_ = 0;
  int64_t min_offset_before_ns_ = 0;
  base::MonotonicTime window_begin_;
  base::MonotonicTime last_stamp_;
  // Wheels (counts).
  int64_t left_ = 0;
  int64_t right_ = 0;
};

}  // namespace treeline::segway

#endif  // NAV_AGENT_DRIVERS_SEGWAY_STATUS_READER_H_
