// What people do to a robot with their own hands: stop it until it is released,
// and drive it.
#ifndef NAV_AGENT_BEHAVIOR_OPERATOR_CONTROL_H_
#define NAV_AGENT_BEHAVIOR_OPERATOR_CONTROL_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/navigator_snapshot.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::behavior {

// Both are events. Not thread-safe.
class LatchedStop {
 public:
  explicit LatchedStop(EventLog& events) : events_(&events) {}

  // The first reason stays. False: it held already.
  bool Hold(const std::string& why, base::MonotonicTime now);
  // False: it did not hold.
  bool Release(base::MonotonicTime now);

  bool is_held() const { return stop_.has_value(); }
  const std::optional<OperatorStop>& stop() const { return stop_; }
  // FAILED_PRECONDITION with the reason while it holds; `what` is refused.
  absl::Status Refuse(const std::string& what) const;

 private:
  EventLog* events_;
  std::optional<OperatorStop> stop_;
};

// The dead man's switch: a command is good for lease_s, kManualLease_s of real
// time. Not thread-safe.
class ManualDrive {
 public:
  explicit ManualDrive(EventLog& events, double lease_s = kManualLease_s)
      : events_(&events), lease_s_(lease_s) {}

  // INVALID_ARGUMENT: not finite.
  absl::Status Drive(const core::VelocityCommand& wanted,
                     base::MonotonicTime now);
  // What is wanted now; nullopt: nobody drives. Called in every step.
  std::optional<core::VelocityCommand> Wanted(base::MonotonicTime now);
  void End();
  // Somebody drove when last asked.
  bool is_active() const { return driven_.has_value(); }

 private:
  EventLog* events_;
  double lease_s_;
  core::VelocityCommand wanted_;
  // The last command's.
  std::optional<base::MonotonicTime> driven_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_OPERATOR_CONTROL_H_
