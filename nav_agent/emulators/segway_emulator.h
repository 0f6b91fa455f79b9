// The base's side of the conversation with a Segway RMP100, byte for byte, with
// faults on request. What a real base does beyond what docs/base-driver.md
// lists as known is not played.
#ifndef NAV_AGENT_EMULATORS_SEGWAY_EMULATOR_H_
#define NAV_AGENT_EMULATORS_SEGWAY_EMULATOR_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "common/base/clock.h"
#include "common/base/random.h"
#include "nav_agent/drivers/segway/segway_codec.h"
#include "nav_agent/drivers/segway/velocity_limits.h"
#include "nav_agent/emulators/base_plant.h"

namespace treeline {

struct SegwayEmulatorOptions {
  // As this base understands them, whatever a driver believes.
  SegwayWire wire{};
  uint8_t channel = kSegwayChannelA;
  SegwayMode mode = SegwayMode::kDisabled;
  double wheel_track_m = 0.54;
  // At full scale (16 of 16). How fast the base brakes without commands, too.
  double max_acceleration_mps2 = 1.5;
  double max_yaw_acceleration_radps2 = 4.0;
  // A motion command is obeyed for this long.
  double command_lifetime_s = 0.4;
  double battery_v = 72;
  // Lost in an hour.
  double battery_drain_v = 1.0;
  uint64_t seed = 0;

  absl::Status Validate() const;
};

// Probabilities are for each frame, in [0, 1].
struct SegwayFaults {
  double corrupt = 0;          // one byte of a frame from the base is changed
  double drop_byte = 0;        // one is lost
  double drop_frame = 0;       // the whole frame is
  double corrupt_command = 0;  // a frame to the base arrives broken
  // That a delivery ends anywhere within a frame; the rest comes with the next.
  double split = 0;
  // Deliveries come only this often, all at once; 0: as soon as they can.
  double merge_s = 0;
  bool stuck_left_wheel = false;
  bool stuck_right_wheel = false;
  bool motors_disabled = false;
  // Nothing goes through in either direction, as when the cable is pulled.
  bool unplugged = false;

  absl::Status Validate() const;
};

// What a driver has been seen to do, so that drivers can be judged.
struct SegwayEmulatorCounts {
  int64_t commands = 0;
  int64_t broken_commands = 0;  // bytes that were no frame, in runs
  int64_t too_soon = 0;         // less than 10 ms after the one before
  int64_t too_late = 0;         // the base had begun to coast
  int64_t settings = 0;
  int64_t cycles = 0;
};

// Not thread-safe. Time comes in with each call and must not run backwards.
class SegwayEmulator {
 public:
  // Valid options. The plant outlives the emulator.
  SegwayEmulator(const SegwayEmulatorOptions& options, BasePlant& plant,
                 MonotonicTime now);

  // Bytes from the driver.
  void Receive(std::span<const uint8_t> bytes, MonotonicTime now);
  // Moves the base on to `now`, a step each 10 ms, and returns what has come
  // out of its port since the last call.
  std::vector<uint8_t> Advance(MonotonicTime now);
  // When the next status cycle is due.
  MonotonicTime NextCycle() const { return next_cycle_; }

  // The same without taking anything out.
  void CatchUp(MonotonicTime now) { AdvanceTo(now); }

  // `faults` are valid. They begin with the next step.
  void SetFaults(const SegwayFaults& faults);
  const SegwayFaults& faults() const { return faults_; }

  // The truth.
  const BasePlantState& state() const { return state_; }
  SegwayMode mode() const { return mode_; }
  const SegwayEmulatorCounts& counts() const { return counts_; }

 private:
  struct Integrators {
    double left_m = 0;
    double right_m = 0;
    double yaw_rad = 0;
    double forward_m = 0;
  };

  void AdvanceTo(MonotonicTime now);
  void Step();
  void TakeMotion(const SegwayMotion& motion, MonotonicTime now);
  void Set(SegwaySetting setting, uint16_t value);
  VelocityCommand Wanted() const;
  VelocityCommand WithStuckWheels(const VelocityCommand& wanted) const;
  SegwayCycle Cycle() const;
  void Emit(const SegwayMessage& message);
  void EmitPowerStatus();

  const SegwayEmulatorOptions options_;
  BasePlant& plant_;
  SegwayFaults faults_;
  Random random_;
  SegwayFrameParser parser_{SegwayDirection::kToBase};
  SegwayEmulatorCounts counts_;

  const MonotonicTime start_;
  MonotonicTime next_cycle_;
  // The base's own count of its steps.
  int64_t steps_ = 0;

  SegwayMode mode_;
  uint16_t gain_ = 0;
  int velocity_scale_ = 16;
  int acceleration_scale_ = 16;
  int turn_scale_ = 16;
  SegwayMotion motion_;
  std::optional<MonotonicTime> motion_at_;
  // The speeds that the base has reached.
  VelocityCommand moving_;
  BasePlantState state_;
  // What the counters counted, and where they were when they were last reset.
  Integrators integrated_;
  Integrators zero_;

  std::vector<uint8_t> output_;
  MonotonicTime next_delivery_;
};

}  // namespace treeline

#endif  // NAV_AGENT_EMULATORS_SEGWAY_EMULATOR_H_
