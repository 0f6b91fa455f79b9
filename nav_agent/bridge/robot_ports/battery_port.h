// A battery that speaks sensor_msgs/BatteryState.
#ifndef NAV_AGENT_BRIDGE_ROBOT_PORTS_BATTERY_PORT_H_
#define NAV_AGENT_BRIDGE_ROBOT_PORTS_BATTERY_PORT_H_

#include <optional>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/core/battery.h"

namespace treeline::robot_ports {

// Thread-safe.
class BatteryPort {
 public:
  // real_clock must outlive it.
  explicit BatteryPort(const base::Clock& real_clock)
      : real_clock_(real_clock) {}

  // What is NaN is not told, as the message's definition has it. Full batteries
  // do not say whether they charge. INVALID_ARGUMENT: a percentage outside of
  // [0, 1], or a voltage below 0; it is dropped.
  absl::Status Add(const messages::BatteryState& message);

  // The newest; nullopt: none has come for a minute.
  std::optional<core::Battery> battery() const;

 private:
  const base::Clock& real_clock_;
  mutable absl::Mutex mutex_;
  std::optional<core::Battery> battery_ ABSL_GUARDED_BY(mutex_);
  base::MonotonicTime came_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::robot_ports

#endif  // NAV_AGENT_BRIDGE_ROBOT_PORTS_BATTERY_PORT_H_
