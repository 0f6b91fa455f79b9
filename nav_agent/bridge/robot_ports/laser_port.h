// A laser that speaks sensor_msgs/LaserScan.
#ifndef NAV_AGENT_BRIDGE_ROBOT_PORTS_LASER_PORT_H_
#define NAV_AGENT_BRIDGE_ROBOT_PORTS_LASER_PORT_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/bridge/robot_ports/port_health.h"
#include "nav_agent/bridge/robot_ports/ros_time.h"
#include "nav_agent/core/devices.h"

namespace treeline::robot_ports {

// Thread-safe.
class LaserPort final : public core::RangeSensor {
 public:
  // All must outlive it.
  LaserPort(const std::string& topic, const RosTime& time,
            const base::Clock& real_clock)
      : time_(time), real_clock_(real_clock), health_(topic) {}

  // The scans after the first one are made to have its beams: some lasers give
  // a few more or fewer each time. Beams that run clockwise are turned round.
  // INVALID_ARGUMENT for what is no scan; it is counted, and dropped.
  absl::Status Add(const messages::LaserScan& message);
  // It is mounted upside down: its frame is looked at as if turned about its x
  // axis by pi, and so are beams. Before anything is taken.
  void SetUpsideDown();

  // header.frame_id of the newest scan; "": none has come.
  std::string frame_id() const;

  core::RangeSensorInfo Info() const override;
  std::vector<core::LaserScan> TakeScans() override;
  core::DeviceHealth Health() const override;

 private:
  const RosTime& time_;
  const base::Clock& real_clock_;
  mutable absl::Mutex mutex_;
  PortHealth health_ ABSL_GUARDED_BY(mutex_);
  Waiting<core::LaserScan> waiting_ ABSL_GUARDED_BY(mutex_);
  bool is_upside_down_ ABSL_GUARDED_BY(mutex_) = false;
  // Counter-clockwise.
  std::optional<core::RangeSensorInfo> info_ ABSL_GUARDED_BY(mutex_);
  std::string frame_id_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::robot_ports

#endif  // NAV_AGENT_BRIDGE_ROBOT_PORTS_LASER_PORT_H_
