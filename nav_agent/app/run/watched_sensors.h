// Laser, wheels and camera on their way to the navigator.
#ifndef NAV_AGENT_APP_RUN_WATCHED_SENSORS_H_
#define NAV_AGENT_APP_RUN_WATCHED_SENSORS_H_

#include <memory>

#include "nav_agent/app/run/agent_recorder.h"
#include "nav_agent/core/corrected_devices.h"
#include "nav_agent/core/devices.h"
#include "nav_agent/service/battery_tap.h"

namespace treeline::run_app {

// They are recorded as they are, the battery is noted, and the navigator gets
// them as the robot's calibration corrects them. Devices and recorder must
// outlive it.
class WatchedSensors {
 public:
  // recorder: null, nothing is recorded.
  WatchedSensors(core::RangeSensor& laser, core::Odometry& odometry,
                 const core::SensorCorrection& correction,
                 AgentRecorder* recorder);

  core::RangeSensor& laser() { return *laser_; }
  core::Odometry& odometry() { return *odometry_; }
  // `camera`, which is recorded by others, as it is to be understood. It must
  // outlive this, and is asked for once.
  core::RgbdCamera& Corrected(core::RgbdCamera& camera);
  agent_service::BatteryTap& battery() { return *battery_; }

 private:
  std::unique_ptr<RecordedLaser> recorded_laser_;
  std::unique_ptr<RecordedOdometry> recorded_odometry_;
  std::unique_ptr<agent_service::BatteryTap> battery_;
  std::unique_ptr<core::CorrectedLaser> corrected_laser_;
  std::unique_ptr<core::CorrectedOdometry> corrected_odometry_;
  std::unique_ptr<core::CorrectedCamera> corrected_camera_;
  const core::SensorCorrection correction_;
  // The last of each.
  core::RangeSensor* laser_;
  core::Odometry* odometry_;
};

}  // namespace treeline::run_app

#endif  // NAV_AGENT_APP_RUN_WATCHED_SENSORS_H_
