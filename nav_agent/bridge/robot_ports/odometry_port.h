// Wheels that speak nav_msgs/Odometry.
#ifndef NAV_AGENT_BRIDGE_ROBOT_PORTS_ODOMETRY_PORT_H_
#define NAV_AGENT_BRIDGE_ROBOT_PORTS_ODOMETRY_PORT_H_

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "common/ros2/messages/nav_messages.h"
#include "nav_agent/bridge/robot_ports/port_health.h"
#include "nav_agent/bridge/robot_ports/ros_time.h"
#include "nav_agent/core/devices.h"

namespace treeline::robot_ports {

// The ways of two wheels are made of the poses: along the robot's x axis, and
// about it. What moves it sideways is left out, as of the agent's own drivers.
// Pitch and roll are those of the poses. A pose that leaps further than the
// robot can drive (odometry that was reset, or corrected by something else)
// begins anew: wheels have not turned. Thread-safe.
class OdometryPort final : public core::Odometry {
 public:
  // All must outlive it.
  OdometryPort(const std::string& topic, double wheel_track_m,
               const RosTime& time, const base::Clock& real_clock)
      : wheel_track_m_(wheel_track_m),
        time_(time),
        real_clock_(real_clock),
        health_(topic) {}

  // Where the robot's base is in the frame child_frame_id. INVALID_ARGUMENT for
  // what is not finite, no rotation, too fast for any robot, or of another
  // clock; it is counted, and dropped.
  absl::Status Add(const messages::Odometry& message,
                   const geometry::Rigid3& child_from_base);

  // What could not be made ready for Add counts as broken, too. Returns `why`.
  absl::Status Refuse(const absl::Status& why);

  // Of the last two seconds; the newest for what is newer. nullopt: there is
  // none.
  std::optional<geometry::Rigid3> OdomFromBaseAt(
      base::MonotonicTime stamp) const;
  // header.frame_id of the newest: "odom". "": none has come.
  std::string frame_id() const;
  // How often the poses leapt.
  int64_t leaps() const;

  std::vector<core::BaseReading> TakeReadings() override;
  core::DeviceHealth Health() const override;

 private:
  struct Moment {
    base::MonotonicTime stamp;
    geometry::Rigid3 odom_from_base;
  };
  void TurnWheels(const Moment& from, const Moment& to)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const double wheel_track_m_;
  const RosTime& time_;
  const base::Clock& real_clock_;
  mutable absl::Mutex mutex_;
  PortHealth health_ ABSL_GUARDED_BY(mutex_);
  Waiting<core::BaseReading> waiting_ ABSL_GUARDED_BY(mutex_);
  std::deque<Moment> trail_ ABSL_GUARDED_BY(mutex_);
  double left_wheel_m_ ABSL_GUARDED_BY(mutex_) = 0;
  double right_wheel_m_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t leaps_ ABSL_GUARDED_BY(mutex_) = 0;
  std::string frame_id_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::robot_ports

#endif  // NAV_AGENT_BRIDGE_ROBOT_PORTS_ODOMETRY_PORT_H_
