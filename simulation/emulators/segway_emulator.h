// The base's side of the conversation with a Segway RMP100, byte for byte, with
// faults on request. What a real base does beyond what
// docs/reference/base-driver.md lists as known is not played.
#ifndef SIMULATION_EMULATORS_SEGWAY_EMULATOR_H_
#define SIMULATION_EMULATORS_SEGWAY_EMULATOR_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "common/base/clock.h"
#include "common/base/random.h"
#include "nav_agent/drivers/segway/segway_codec.h"
#include "nav_agent/drivers/segway/velocity_limits.h"
#include "simulation/emulators/base_plant.h"

namespace treeline::emulators {

struct SegwayEmulatorOptions {
  // As this base understands them, whatever a driver assumes.
  segway::SegwayWire wire{};
  uint8_t channel = segway::kSegwayChannelA;
  segway::SegwayMode mode = segway::SegwayMode::kDisabled;
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
                 base::MonotonicTime now);

  // Bytes from the driver.
  void Receive(std::span<const uint8_t> bytes, base::MonotonicTime now);
  // Moves the base on to `now`, a step each 10 ms, and returns what has come
  // out of its port since the last call.
  std::vector<uint8_t> Advance(base::MonotonicTime now);
  // When the next status cycle is due.
  base::MonotonicTime NextCycle() const { return next_cycle_; }

  // The same without taking anything out.
  void CatchUp(base::MonotonicTime now) { AdvanceTo(now); }

  // `faults` are valid. They begin with the next step.
  void SetFaults(const SegwayFaults& faults);
  const SegwayFaults& faults() const { return faults_; }

  // The truth.
  const BasePlantState& state() const { return state_; }
  segway::SegwayMode mode() const { return mode_; }
  const SegwayEmulatorCounts& counts() const { return counts_; }

 private:
  struct Integrators {
    double left_m = 0;
    double right_m = 0;
    double yaw_rad = 0;
    double forward_m = 0;
  };

  void AdvanceTo(base::MonotonicTime now);
  void Step();
  void TakeMotion(const segway::SegwayMotion& motion, base::MonotonicTime now);
  void Set(segway::SegwaySetting setting, uint16_t value);
  core::VelocityCommand Wanted() const;
  core::VelocityCommand WithStuckWheels(
      const core::VelocityCommand& wanted) const;
  segway::SegwayCycle Cycle() const;
  void Emit(const segway::SegwayMessage& message);
  void EmitPowerStatus();

  const SegwayEmulatorOptions options_;
  BasePlant& plant_;
  SegwayFaults faults_;
  base::Random random_;
  segway::SegwayFrameParser parser_{segway::SegwayDirection::kToBase};
  SegwayEmulatorCounts counts_;

  const base::MonotonicTime start_;
  base::MonotonicTime next_cycle_;
  // The base's own count of its steps.
  int64_t steps_ = 0;

  segway::SegwayMode mode_;
  uint16_t gain_ = 0;
  int velocity_scale_ = 16;
  int acceleration_scale_ = 16;
  int turn_scale_ = 16;
  segway::SegwayMotion motion_;
  std::optional<base::MonotonicTime> motion_at_;
  // The speeds that the base has reached.
  core::VelocityCommand moving_;
  BasePlantState state_;
  // What the counters counted, and where they were when they were last reset.
  Integrators integrated_;
  Integrators zero_;

  std::vector<uint8_t> output_;
  base::MonotonicTime next_delivery_;
};

}  // namespace treeline::emulators

#endif  // SIMULATION_EMULATORS_SEGWAY_EMULATOR_H_
