// The conversation with a Segway RMP100: what to send when, and what the
// answers mean. Bytes and times go in, bytes and readings come out; it neither
// waits nor has a clock, so that tests need no time.
//
//   Connected -> listening: stop frames, until a status cycle is heard
//             -> configuring: the settings, one a frame, with zero velocity,
//                until the base reports the mode that was asked for
//             -> ready: commands are obeyed
//   Silence leads back to listening, the closing of the link to disconnected.
//   Wherever it is not ready, only stop frames are sent.
//
// The watchdog: kCommandLifetime_s after it was given a command is forgotten,
// and stop frames follow at once; the base then brakes by its own limits. A
// command never outlives the loss of the link, a fault or an emergency stop
// either: each asks for a new one. A base that turns the wrong way (TurnWatch)
// is stopped for good. If this machine falls silent, the base
// itself coasts to a stop after about 400 ms.
#ifndef NAV_AGENT_DRIVERS_SEGWAY_SEGWAY_PROTOCOL_H_
#define NAV_AGENT_DRIVERS_SEGWAY_SEGWAY_PROTOCOL_H_

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "common/base/clock.h"
#include "nav_agent/core/devices.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/drivers/segway/segway_codec.h"
#include "nav_agent/drivers/segway/segway_options.h"
#include "nav_agent/drivers/segway/status_reader.h"
#include "nav_agent/drivers/segway/turn_watch.h"

namespace treeline::segway {

// For people who look for a fault; all since the start.
struct SegwayStatistics {
  int64_t discarded_bytes = 0;    // belonged to no frame
  int64_t discarded_runs = 0;     // and in how many pieces they came
  int64_t incomplete_cycles = 0;  // a message was missing
  int64_t implausible_cycles = 0;
  int64_t expired_commands = 0;  // the watchdog stopped the base
  int64_t heartbeats = 0;
  // From the last cycle; nullopt before the first.
  std::optional<SegwayCycle> cycle{};
  std::optional<uint8_t> channel{};
};

// Not thread-safe.
class SegwayProtocol {
 public:
  // `options` are valid.
  explicit SegwayProtocol(const SegwayOptions& options);

  // The link is there (again), or not any longer, and why.
  void Connected(base::MonotonicTime now);
  void Disconnected(const absl::Status& cause, base::MonotonicTime now);
  // Bytes have come.
  void Receive(std::span<const uint8_t> bytes, base::MonotonicTime now);
  // What has to be written now: nothing before NextSend(). Call it at least
  // every 100 ms; it also notices silence.
  std::vector<uint8_t> Send(base::MonotonicTime now);
  base::MonotonicTime NextSend() const { return next_send_; }
  // Whether the link is of no use, so that it should be opened anew.
  bool ShouldReopen(base::MonotonicTime now) const;

  // BaseDriver. INVALID_ARGUMENT for NaN and infinity; UNAVAILABLE while the
  // base is lost or not yet configured; FAILED_PRECONDITION while it is in
  // another mode, its motors are disabled, an emergency stop is engaged, or it
  // has turned the wrong way.
  // With each of these, the base is stopped.
  absl::Status SetVelocity(const core::VelocityCommand& command,
                           base::MonotonicTime now);
  // Slows down by max_deceleration_mps2.
  void Stop();
  // Stop frames at once, and no commands until it is released.
  void SetEmergencyStop(bool engaged);

  std::vector<core::BaseReading> TakeReadings();
  core::DeviceHealth Health() const;
  SegwayStatistics Statistics() const;

 private:
  enum class Phase { kDisconnected, kListening, kConfiguring, kReady };
  struct Setting {
    SegwaySetting setting;
    uint16_t value;
  };

  void TakeMessage(const SegwayMessage& message, base::MonotonicTime now);
  void TakeReading(const core::BaseReading& reading, base::MonotonicTime now);
  void CheckLink(base::MonotonicTime now);
  void Lose(const absl::Status& cause);
  void BeginConfiguring();
  void CheckConfigured(base::MonotonicTime now);
  void ForgetCommand();
  // OK if a command would be obeyed.
  absl::Status Readiness() const;
  absl::Status SilenceCause() const;
  core::VelocityCommand NextVelocity(base::MonotonicTime now);
  SegwayMotion NextMotion(base::MonotonicTime now);
  bool InWantedMode() const;

  const SegwayOptions options_;
  SegwayFrameParser parser_{SegwayDirection::kFromBase};
  SegwayStatusReader reader_;
  TurnWatch turn_watch_;

  Phase phase_ = Phase::kDisconnected;
  absl::Status cause_;  // of kDisconnected, and of silence
  bool ever_ready_ = false;
  int64_t losses_ = 0;
  base::MonotonicTime connected_at_;
  base::MonotonicTime last_cycle_at_;
  // Since the connection began.
  bool heard_bytes_ = false;
  bool heard_frames_ = false;
  bool heard_cycle_ = false;
  bool motors_enabled_ = true;
  int64_t heartbeats_ = 0;

  // What is still to be set, the next one first; when the last was sent.
  std::deque<Setting> settings_;
  base::MonotonicTime configured_at_;
  int attempts_ = 0;
  // When the base was first seen in another mode than wanted while ready.
  std::optional<base::MonotonicTime> astray_since_;

  std::optional<core::VelocityCommand> command_;
  base::MonotonicTime command_at_;
  int64_t expired_ = 0;
  bool braking_ = false;
  bool emergency_stop_ = false;
  core::VelocityCommand sent_;
  base::MonotonicTime last_send_;
  base::MonotonicTime next_send_;

  std::deque<core::BaseReading> readings_;
  int64_t received_ = 0;
  int64_t dropped_ = 0;
};

}  // namespace treeline::segway

#endif  // NAV_AGENT_DRIVERS_SEGWAY_SEGWAY_PROTOCOL_H_
