#include "nav_agent/bridge/robot_ports/battery_port.h"

#include <cmath>

#include "absl/strings/str_cat.h"

namespace treeline::robot_ports {
namespace {

// Batteries speak every few seconds; what is older is not known any more (s).
constexpr double kOldest_s = 60;

core::Charging ChargingOf(uint8_t status) {
  switch (status) {
    case messages::BatteryState::kCharging:
      return core::Charging::kYes;
    case messages::BatteryState::kDischarging:
    case messages::BatteryState::kNotCharging:
      return core::Charging::kNo;
    default:
      return core::Charging::kUnknown;
  }
}

}  // namespace

absl::Status BatteryPort::Add(const messages::BatteryState& message) {
  core::Battery battery = {.charging = ChargingOf(message.power_supply_status)};
  if (std::isfinite(message.voltage)) battery.voltage_v = message.voltage;
  if (std::isfinite(message.percentage)) battery.charge = message.percentage;
  if (battery.voltage_v < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("the battery has ", message.voltage, " V"));
  }
  if (battery.charge.has_value() &&
      !(*battery.charge >= 0 && *battery.charge <= 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the battery's percentage is ", message.percentage,
                     "; BatteryState has it from 0 to 1"));
  }
  const absl::MutexLock lock(&mutex_);
  battery_ = battery;
  came_ = real_clock_.Now();
  return absl::OkStatus();
}

std::optional<core::Battery> BatteryPort::battery() const {
  const absl::MutexLock lock(&mutex_);
  if (battery_.has_value() &&
      base::SecondsBetween(came_, real_clock_.Now()) > kOldest_s) {
    return std::nullopt;
  }
  return battery_;
}

}  // namespace treeline::robot_ports
