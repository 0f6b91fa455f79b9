#include "simulation/emulators/segway_device.h"

#include <vector>

namespace treeline::emulators {
namespace {

constexpr int kMotorsDisabled = 1;
constexpr int kLeftWheelStuck = 2;
constexpr int kRightWheelStuck = 4;

}  // namespace

void SegwayDevice::Connect(base::MonotonicTime now) {
  // It drove on meanwhile, and told nobody.
  emulator_.Advance(now);
}

void SegwayDevice::SetFaults(const ActiveFaults& faults,
                             base::MonotonicTime now) {
  emulator_.CatchUp(now);
  emulator_.SetFaults(
      {.stuck_left_wheel = (faults.error_status & kLeftWheelStuck) != 0,
       .stuck_right_wheel = (faults.error_status & kRightWheelStuck) != 0,
       .motors_disabled = (faults.error_status & kMotorsDisabled) != 0});
}

void SegwayDevice::Receive(std::span<const uint8_t> bytes,
                           base::MonotonicTime now) {
  emulator_.Receive(bytes, now);
}

std::string SegwayDevice::TakeOutput(base::MonotonicTime now) {
  const std::vector<uint8_t> bytes = emulator_.Advance(now);
  return {bytes.begin(), bytes.end()};
}

}  // namespace treeline::emulators
