// A device as a program plays it: bytes and the time in, bytes out.
#ifndef SIMULATION_EMULATORS_EMULATED_DEVICE_H_
#define SIMULATION_EMULATORS_EMULATED_DEVICE_H_

#include <cstdint>
#include <span>
#include <string>

#include "common/base/clock.h"
#include "simulation/emulators/fault_plan.h"

namespace treeline::emulators {

// Not thread-safe: EmulatorServer calls it from one thread, with times that
// never decrease.
class EmulatedDevice {
 public:
  virtual ~EmulatedDevice() = default;
  // Someone has connected, over TCP, or it was plugged in (again).
  virtual void Connect(base::MonotonicTime now) = 0;
  // The faults that it shows itself (error_status, skew_ppm); those of the
  // connection are not its business.
  virtual void SetFaults(const ActiveFaults& faults,
                         base::MonotonicTime now) = 0;
  virtual void Receive(std::span<const uint8_t> bytes,
                       base::MonotonicTime now) = 0;
  // All that it has sent up to `now` and since the last call.
  virtual std::string TakeOutput(base::MonotonicTime now) = 0;
  // When it will next send something by itself.
  virtual base::MonotonicTime NextEvent() const = 0;
};

}  // namespace treeline::emulators

#endif  // SIMULATION_EMULATORS_EMULATED_DEVICE_H_
