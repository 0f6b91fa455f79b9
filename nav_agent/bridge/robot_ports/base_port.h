// A base that takes velocities as geometry_msgs/Twist: /cmd_vel.
#ifndef NAV_AGENT_BRIDGE_ROBOT_PORTS_BASE_PORT_H_
#define NAV_AGENT_BRIDGE_ROBOT_PORTS_BASE_PORT_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "nav_agent/core/devices.h"

namespace treeline::robot_ports {

// While it has nothing to say it is silent, so that somebody else can drive: a
// second after the robot was told to stand. Thread-safe.
class BasePort final : public core::BaseDriver {
 public:
  struct Wire {
    // A velocity goes out.
    std::function<absl::Status(const core::VelocityCommand&)> send;
    // How many listen.
    std::function<int()> listeners;
    // Why the robot may not move now; OK: it may.
    std::function<absl::Status()> obstacle;
    // Why nobody listens.
    std::function<std::string()> why_nobody = [] { return std::string(); };
  };
  // real_clock must outlive it.
  BasePort(std::string topic, const base::Clock& real_clock, Wire wire);
  // Stops the robot, if it was told to move.
  ~BasePort() override;

  absl::Status SetVelocity(const core::VelocityCommand& command) override;
  void Stop() override;
  core::DeviceHealth Health() const override;

  // Ends a command that is too old: whoever gave it is stuck. To be called
  // often, by another thread than the one that drives.
  void Watch();

 private:
  void Send(const core::VelocityCommand& command)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string topic_;
  const base::Clock& real_clock_;
  const Wire wire_;
  mutable absl::Mutex mutex_;
  core::VelocityCommand last_ ABSL_GUARDED_BY(mutex_);
  // When `last_` was given; and until when zeros are still sent.
  base::MonotonicTime given_ ABSL_GUARDED_BY(mutex_);
  std::optional<base::MonotonicTime> moved_ ABSL_GUARDED_BY(mutex_);
  absl::Status last_error_ ABSL_GUARDED_BY(mutex_);
  int64_t sent_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace treeline::robot_ports

#endif  // NAV_AGENT_BRIDGE_ROBOT_PORTS_BASE_PORT_H_
