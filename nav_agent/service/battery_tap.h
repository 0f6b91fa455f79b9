// The battery of a base that tells it with its wheels.
#ifndef NAV_AGENT_SERVICE_BATTERY_TAP_H_
#define NAV_AGENT_SERVICE_BATTERY_TAP_H_

#include <optional>
#include <vector>

#include "nav_agent/core/battery.h"
#include "nav_agent/core/devices.h"

namespace treeline::agent_service {

// An odometry that remembers the newest voltage of those that went through.
// TakeReadings and battery by one thread.
class BatteryTap final : public core::Odometry {
 public:
  // `odometry` must outlive it.
  explicit BatteryTap(core::Odometry& odometry) : odometry_(odometry) {}

  std::vector<core::BaseReading> TakeReadings() override {
    std::vector<core::BaseReading> readings = odometry_.TakeReadings();
    for (const core::BaseReading& reading : readings) {
      if (reading.battery_v <= 0) continue;
      battery_ = core::Battery{.voltage_v = reading.battery_v};
    }
    return readings;
  }
  core::DeviceHealth Health() const override { return odometry_.Health(); }

  // nullopt: the base has not told any.
  const std::optional<core::Battery>& battery() const { return battery_; }

 private:
  core::Odometry& odometry_;
  std::optional<core::Battery> battery_;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_BATTERY_TAP_H_
