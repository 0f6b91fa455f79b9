// What a robot's battery says of itself.
#ifndef NAV_AGENT_CORE_BATTERY_H_
#define NAV_AGENT_CORE_BATTERY_H_

#include <cstdint>
#include <optional>

namespace treeline::core {

enum class Charging : uint8_t { kUnknown, kNo, kYes };

struct Battery {
  // 0: it does not tell.
  double voltage_v = 0;
  // Of a full one, in [0, 1]; nullopt: it does not tell.
  std::optional<double> charge = std::nullopt;
  Charging charging = Charging::kUnknown;

  bool operator==(const Battery&) const = default;
};

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_BATTERY_H_
