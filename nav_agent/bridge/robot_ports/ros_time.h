// The agent's time, and what stamps of messages are in it.
#ifndef NAV_AGENT_BRIDGE_ROBOT_PORTS_ROS_TIME_H_
#define NAV_AGENT_BRIDGE_ROBOT_PORTS_ROS_TIME_H_

#include <cstdint>
#include <functional>
#include <optional>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "common/ros2/messages/common_messages.h"

namespace treeline::robot_ports {

// Never goes back, whatever the clock of the system or a simulation does: who
// drives by it measures durations. Thread-safe.
class RosTime final : public base::Clock {
 public:
  // Nanoseconds since 1970 by the clock of the system, which people and NTP
  // set.
  using SystemClock = std::function<int64_t()>;

  // is_simulated: time is what /clock says (Set). `steady` must outlive it.
  RosTime(bool is_simulated, const base::Clock& steady,
          SystemClock system_now_ns);

  // The steady clock; or that of the simulation, carried on between its
  // messages by no more than from one to the next. It stands until the first.
  base::MonotonicTime Now() const override;
  // A message of /clock. One that goes back by less than 0.1 s came out of
  // order and is left out; by more, the clock was set back, and time goes on
  // from where it was.
  void Set(const messages::Clock& clock);
  // Looks whether the system's clock was set; to be called now and then.
  void Watch();

  base::MonotonicTime TimeOf(const messages::Time& stamp) const;
  messages::Time StampOf(base::MonotonicTime time) const;

  // INVALID_ARGUMENT, with what to do, for a stamp of another clock: one that
  // is 0, or more than 10 s off.
  absl::Status CheckStamp(const messages::Time& stamp) const;

  // How often the clock that stamps are of was set, by 0.1 s or more, or that
  // of a simulation leapt ahead by more than 2 s.
  int64_t jumps() const;
  bool is_simulated() const { return is_simulated_; }
  // Whether /clock has come, and not longer ago than half a second of real
  // time; always, where there is no simulation.
  bool is_running() const;

 private:
  base::MonotonicTime NowLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // What is added to a stamp (ns).
  int64_t Shift_ns() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const bool is_simulated_;
  const base::Clock& steady_;
  const SystemClock system_now_ns_;
  mutable absl::Mutex mutex_;
  int64_t jumps_ ABSL_GUARDED_BY(mutex_) = 0;
  // ---- of the system ----
  std::optional<int64_t> last_shift_ns_ ABSL_GUARDED_BY(mutex_);
  // ---- of a simulation ----
  int64_t shift_ns_ ABSL_GUARDED_BY(mutex_) = 0;
  std::optional<int64_t> clock_ns_ ABSL_GUARDED_BY(mutex_);
  base::MonotonicTime came_ ABSL_GUARDED_BY(mutex_);
  // From the message before to the last one, simulated and real.
  int64_t period_ns_ ABSL_GUARDED_BY(mutex_) = 0;
  double pace_ ABSL_GUARDED_BY(mutex_) = 0;
  // The latest that was told.
  mutable base::MonotonicTime told_ ABSL_GUARDED_BY(mutex_);
};

// Of this machine.
int64_t SystemNow_ns();

}  // namespace treeline::robot_ports

#endif  // NAV_AGENT_BRIDGE_ROBOT_PORTS_ROS_TIME_H_
