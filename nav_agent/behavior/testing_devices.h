// A clock and devices without a robot, for tests.
#ifndef NAV_AGENT_BEHAVIOR_TESTING_DEVICES_H_
#define NAV_AGENT_BEHAVIOR_TESTING_DEVICES_H_

#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "nav_agent/core/devices.h"

namespace treeline::behavior {

class ManualClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override { return now_; }
  void Advance_s(double seconds) {
    now_ += std::chrono::nanoseconds(std::llround(seconds * 1e9));
  }

 private:
  base::MonotonicTime now_{std::chrono::seconds(100)};
};

template <typename Port, typename T>
class FakeSensor : public Port {
 public:
  core::DeviceHealth Health() const override { return health; }

  std::vector<T> waiting;
  core::DeviceHealth health = {.state = core::DeviceState::kRunning};

 protected:
  std::vector<T> TakeAll() { return std::exchange(waiting, {}); }
};

class FakeLaser final : public FakeSensor<core::RangeSensor, core::LaserScan> {
 public:
  core::RangeSensorInfo Info() const override { return info; }
  std::vector<core::LaserScan> TakeScans() override { return TakeAll(); }

  core::RangeSensorInfo info = {.angle_min_rad = -1.5,
                                .angle_increment_rad = 0.1,
                                .beams = 31,
                                .range_min_m = 0.1,
                                .range_max_m = 30,
                                .beam_interval_s = 0,
                                .scan_interval_s = 0.025};
};

class FakeOdometry final
    : public FakeSensor<core::Odometry, core::BaseReading> {
 public:
  std::vector<core::BaseReading> TakeReadings() override { return TakeAll(); }
};

class FakeCamera final : public FakeSensor<core::RgbdCamera, core::RgbdFrame> {
 public:
  camera::RgbdCalibration Calibration() const override { return {}; }
  std::vector<core::RgbdFrame> TakeFrames() override {
    ++takes;
    return TakeAll();
  }
  int takes = 0;
};

class FakeBase final : public core::BaseDriver {
 public:
  absl::Status SetVelocity(const core::VelocityCommand& command) override {
    if (!answer.ok()) return answer;
    commands.push_back(command);
    return absl::OkStatus();
  }
  void Stop() override { ++stops; }
  core::DeviceHealth Health() const override { return health; }

  absl::Status answer;
  core::DeviceHealth health = {.state = core::DeviceState::kRunning};
  std::vector<core::VelocityCommand> commands;
  int stops = 0;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_TESTING_DEVICES_H_
