// An emulated base for EmulatorServer.
#ifndef NAV_AGENT_EMULATORS_SEGWAY_DEVICE_H_
#define NAV_AGENT_EMULATORS_SEGWAY_DEVICE_H_

#include <cstdint>
#include <span>
#include <string>

#include "common/base/clock.h"
#include "nav_agent/emulators/emulated_device.h"
#include "nav_agent/emulators/segway_emulator.h"

namespace treeline {

// The faults of a connection are the server's. An error_status is what is
// broken, added up: 1 the motors are disabled, 2 the left wheel is stuck, 4 the
// right one is. Skew is not played.
class SegwayDevice final : public EmulatedDevice {
 public:
  SegwayDevice(const SegwayEmulatorOptions& options, BasePlant& plant,
               MonotonicTime now)
      : emulator_(options, plant, now) {}

  void Connect(MonotonicTime now) override;
  void SetFaults(const ActiveFaults& faults, MonotonicTime now) override;
  void Receive(std::span<const uint8_t> bytes, MonotonicTime now) override;
  std::string TakeOutput(MonotonicTime now) override;
  MonotonicTime NextEvent() const override { return emulator_.NextCycle(); }

  // While no server has it.
  const SegwayEmulator& emulator() const { return emulator_; }

 private:
  SegwayEmulator emulator_;
};

}  // namespace treeline

#endif  // NAV_AGENT_EMULATORS_SEGWAY_DEVICE_H_
