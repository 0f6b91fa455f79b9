// The ports through which the agent knows its robot. Hardware, the simulator
// and recordings stand behind the same ones.
//
// Sensors are polled: Take... hands over what has arrived since the last call,
// oldest first, and never waits. Each keeps at most kMaxWaiting measurements
// and drops the oldest beyond that, which its health counts. Implementations
// are thread-safe.
#ifndef NAV_AGENT_CORE_DEVICES_H_
#define NAV_AGENT_CORE_DEVICES_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "common/camera/rgbd_calibration.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::core {

inline constexpr int kMaxWaiting = 64;

enum class DeviceState {
  kStarting,  // nothing has been heard yet
  kRunning,
  kLost  // silent, unplugged or broken; it is being tried again
};

struct DeviceHealth {
  DeviceState state = DeviceState::kStarting;
  // Why it is not running: what is wrong and what to do about it.
  absl::Status cause = absl::OkStatus();
  // Since the start: measurements that were good, that came broken, that
  // nobody took in time, and how often the device was lost.
  int64_t received = 0;
  int64_t corrupt = 0;
  int64_t dropped = 0;
  int64_t losses = 0;
};

class RangeSensor {
 public:
  virtual ~RangeSensor() = default;
  // Of all scans that are handed over; meaningless while kStarting.
  virtual RangeSensorInfo Info() const = 0;
  virtual std::vector<LaserScan> TakeScans() = 0;
  virtual DeviceHealth Health() const = 0;
};

class RgbdCamera {
 public:
  virtual ~RgbdCamera() = default;
  virtual camera::RgbdCalibration Calibration() const = 0;
  virtual std::vector<RgbdFrame> TakeFrames() = 0;
  virtual DeviceHealth Health() const = 0;
};

class Odometry {
 public:
  virtual ~Odometry() = default;
  virtual std::vector<BaseReading> TakeReadings() = 0;
  virtual DeviceHealth Health() const = 0;
};

class BaseDriver {
 public:
  // No command is obeyed for longer than this after it was given.
  static constexpr double kCommandLifetime_s = 0.3;

  virtual ~BaseDriver() = default;
  // Obeyed until the next one, or until kCommandLifetime_s have passed; then
  // the base is stopped. A command with NaN or infinity stops the base, and is
  // INVALID_ARGUMENT; UNAVAILABLE while the base is lost.
  virtual absl::Status SetVelocity(const VelocityCommand& command) = 0;
  // Stops as fast as the base can without tipping over.
  virtual void Stop() = 0;
  virtual DeviceHealth Health() const = 0;
};

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_DEVICES_H_
