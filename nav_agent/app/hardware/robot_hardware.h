// The drivers of a real robot.
#ifndef NAV_AGENT_APP_HARDWARE_ROBOT_HARDWARE_H_
#define NAV_AGENT_APP_HARDWARE_ROBOT_HARDWARE_H_

#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "nav_agent/core/devices.h"
#include "nav_agent/core/robot_file.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/drivers/hokuyo/hokuyo_laser.h"
#include "nav_agent/drivers/segway/segway_base.h"

namespace treeline::hardware {

// What a robot consists of.
struct HardwareConfig {
  // Where real devices are (ParseStreamAddress). camera: "openni" or "none".
  std::string laser;
  std::string base;
  // A laser that looks back; empty: there is none.
  std::string rear_laser;
  std::string camera = "none";
  core::RobotModel robot;
  core::SensorCorrection correction{};
  // nullopt: nobody measured it.
  std::optional<core::MeasuredOdometryNoise> noise{};
  core::ContactEnd contacts = core::ContactEnd::kUnsaid;

  // INVALID_ARGUMENT: an address is missing or none, no such camera, or the
  // robot's measures contradict each other.
  absl::Status Validate() const;
};

// A YAML file: laser, base, rear_laser, camera, and the robot's measures where
// they are not the default robot's (docs/reference/agent.md). INVALID_ARGUMENT
// names file, line and the key that was probably meant.
absl::StatusOr<HardwareConfig> ReadHardwareConfig(const std::string& path);

// The drivers, at work. They look for their devices by themselves: whether
// those are there, their health tells.
class RobotHardware {
 public:
  // INVALID_ARGUMENT: `config`. `clock` must outlive them.
  static absl::StatusOr<std::unique_ptr<RobotHardware>> Open(
      const HardwareConfig& config, const base::Clock& clock);

  core::RangeSensor& laser() { return *laser_; }
  segway::SegwayBase& base() { return *base_; }
  // Null: there is none.
  core::RangeSensor* rear_laser() { return rear_laser_.get(); }
  core::RgbdCamera* camera() { return camera_.get(); }

 private:
  RobotHardware() = default;

  std::unique_ptr<hokuyo::HokuyoLaser> laser_;
  std::unique_ptr<hokuyo::HokuyoLaser> rear_laser_;
  std::unique_ptr<segway::SegwayBase> base_;
  std::unique_ptr<core::RgbdCamera> camera_;
};

}  // namespace treeline::hardware

#endif  // NAV_AGENT_APP_HARDWARE_ROBOT_HARDWARE_H_
