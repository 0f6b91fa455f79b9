// Clocks and messages for tests of ports.
#ifndef NAV_AGENT_BRIDGE_ROBOT_PORTS_TESTING_PORTS_H_
#define NAV_AGENT_BRIDGE_ROBOT_PORTS_TESTING_PORTS_H_

#include <chrono>
#include <cstdint>

#include "common/base/clock.h"
#include "common/ros2/messages/common_messages.h"
#include "nav_agent/bridge/robot_ports/ros_time.h"

namespace treeline::robot_ports {

class ManualClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override { return now_; }
  void Pass(double seconds) {
    now_ += std::chrono::duration_cast<base::MonotonicTime::duration>(
        std::chrono::duration<double>(seconds));
  }

 private:
  base::MonotonicTime now_ = base::MonotonicTime(std::chrono::hours(1));
};

// A machine whose clocks agree until its own is set: real is the steady clock,
// stamps are of the system's, which is this far ahead (s).
struct TestingTime {
  ManualClock real;
  double system_ahead_s = 1e9;
  RosTime time{false, real, [this] { return SystemNow(); }};

  int64_t SystemNow() const {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               real.Now().time_since_epoch())
               .count() +
           static_cast<int64_t>(system_ahead_s * 1e9);
  }
  messages::Time Stamp() const { return messages::TimeOf(SystemNow()); }
};

}  // namespace treeline::robot_ports

#endif  // NAV_AGENT_BRIDGE_ROBOT_PORTS_TESTING_PORTS_H_
