// An emulated base for EmulatorServer.
#ifndef SIMULATION_EMULATORS_SEGWAY_DEVICE_H_
#define SIMULATION_EMULATORS_SEGWAY_DEVICE_H_

#include <cstdint>
#include <span>
#include <string>

#include "common/base/clock.h"
#include "simulation/emulators/emulated_device.h"
#include "simulation/emulators/segway_emulator.h"

namespace treeline::emulators {

// The faults of a connection are the server's. An error_status is what is
// broken, added up: 1 the motors are disabled, 2 the left wheel is stuck, 4 the
// right one is. Skew is not played.
class SegwayDevice final : public EmulatedDevice {
 public:
  SegwayDevice(const SegwayEmulatorOptions& options, BasePlant& plant,
               base::MonotonicTime now)
      : emulator_(options, plant, now) {}

  void Connect(base::MonotonicTime now) override;
  void SetFaults(const ActiveFaults& faults, base::MonotonicTime now) override;
  void Receive(std::span<const uint8_t> bytes,
               base::MonotonicTime now) override;
  std::string TakeOutput(base::MonotonicTime now) override;
  base::MonotonicTime NextEvent() const override {
    return emulator_.NextCycle();
  }

  // While no server has it.
  const SegwayEmulator& emulator() const { return emulator_; }

 private:
  SegwayEmulator emulator_;
};

}  // namespace treeline::emulators

#endif  // SIMULATION_EMULATORS_SEGWAY_DEVICE_H_
