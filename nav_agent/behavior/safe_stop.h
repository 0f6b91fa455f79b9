// Whether the robot must stand, whatever it was asked to do, and why.
#ifndef NAV_AGENT_BEHAVIOR_SAFE_STOP_H_
#define NAV_AGENT_BEHAVIOR_SAFE_STOP_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/sensor_monitor.h"

namespace treeline::behavior {

// Begins at once, and ends when all has been well for settle_s. Not
// thread-safe.
class SafeStop {
 public:
  SafeStop(const NavigatorLimits& limits, EventLog& events)
      : limits_(limits), events_(&events) {}

  // What a step found; the first is named.
  void Update(const std::vector<StopReason>& found, base::MonotonicTime now);
  bool is_active() const { return reason_.has_value(); }
  // While active.
  const StopReason& reason() const { return *reason_; }
  // FAILED_PRECONDITION with the reason while it is active; `what` is refused.
  absl::Status Refuse(const std::string& what) const;

 private:
  NavigatorLimits limits_;
  EventLog* events_;
  std::optional<StopReason> reason_;
  base::MonotonicTime begun_;
  base::MonotonicTime last_found_;
};

// Tilt that a robot of this model must not stand at. Not thread-safe.
class TiltMonitor {
 public:
  TiltMonitor(const core::RobotModel& robot, const NavigatorLimits& limits)
      : max_rad_(robot.max_slope_rad + limits.tilt_margin_rad),
        for_s_(limits.tilt_s) {}

  void Add(const core::BaseReading& reading);
  std::optional<StopReason> Problem() const;

 private:
  double max_rad_;
  double for_s_;
  double tilt_rad_ = 0;
  base::MonotonicTime stamp_;
  std::optional<base::MonotonicTime> since_;
};

// Whether Step is called in time. Not thread-safe.
class DeadlineMonitor {
 public:
  DeadlineMonitor(double control_hz, const NavigatorLimits& limits,
                  EventLog& events)
      : period_s_(1 / control_hz), late_s_(limits.late_s), events_(&events) {}

  void Step(base::MonotonicTime now);
  // So late that the base was without a command.
  std::optional<StopReason> Problem() const;
  int64_t missed() const { return missed_; }
  double longest_gap_s() const { return longest_gap_s_; }

 private:
  double period_s_;
  double late_s_;
  EventLog* events_;
  std::optional<base::MonotonicTime> last_;
  int64_t missed_ = 0;
  double gap_s_ = 0;
  double longest_gap_s_ = 0;
  std::optional<base::MonotonicTime> noted_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_SAFE_STOP_H_
