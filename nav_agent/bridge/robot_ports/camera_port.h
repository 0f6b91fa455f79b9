// A camera that speaks Image or CompressedImage, with CameraInfo.
#ifndef NAV_AGENT_BRIDGE_ROBOT_PORTS_CAMERA_PORT_H_
#define NAV_AGENT_BRIDGE_ROBOT_PORTS_CAMERA_PORT_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/bridge/place_finder/camera_input.h"
#include "nav_agent/bridge/robot_ports/port_health.h"
#include "nav_agent/bridge/robot_ports/ros_time.h"
#include "nav_agent/core/devices.h"

namespace treeline::robot_ports {

// Pictures are decoded by who takes them, and only the newest, so often.
// Thread-safe.
class CameraPort final : public core::RgbdCamera {
 public:
  // interval_s: from one picture that is handed over to the next. All must
  // outlive it.
  CameraPort(const std::string& topic,
             const place_finder::CameraInput::Options& options,
             double interval_s, const RosTime& time,
             const base::Clock& real_clock)
      : interval_s_(interval_s),
        time_(time),
        real_clock_(real_clock),
        health_(topic),
        input_(options) {}

  absl::Status AddInfo(const messages::CameraInfo& info);
  void AddColor(place_finder::Picture picture);
  void AddDepth(place_finder::Picture picture);

  // Of the newest picture; "": none has come.
  std::string frame_id() const;
  bool has_info() const;

  camera::RgbdCalibration Calibration() const override;
  std::vector<core::RgbdFrame> TakeFrames() override;
  core::DeviceHealth Health() const override;

 private:
  const double interval_s_;
  const RosTime& time_;
  const base::Clock& real_clock_;
  // For what comes; who decodes holds the other one alone.
  mutable absl::Mutex mutex_;
  PortHealth health_ ABSL_GUARDED_BY(mutex_);
  place_finder::CameraInput input_ ABSL_GUARDED_BY(mutex_);
  std::optional<base::MonotonicTime> taken_ ABSL_GUARDED_BY(mutex_);
  // Of the picture that was taken last, as it was stamped.
  std::optional<base::MonotonicTime> stamp_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::robot_ports

#endif  // NAV_AGENT_BRIDGE_ROBOT_PORTS_CAMERA_PORT_H_
