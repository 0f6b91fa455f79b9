#include "nav_agent/app/run/watched_sensors.h"

namespace treeline::run_app {

WatchedSensors::WatchedSensors(core::RangeSensor& laser,
                               core::Odometry& odometry,
                               const core::SensorCorrection& correction,
                               AgentRecorder* recorder)
    : correction_(correction), laser_(&laser), odometry_(&odometry) {
  if (recorder != nullptr) {
    recorded_laser_ = std::make_unique<RecordedLaser>(*laser_, *recorder);
    recorded_odometry_ =
        std::make_unique<RecordedOdometry>(*odometry_, *recorder);
    laser_ = recorded_laser_.get();
    odometry_ = recorded_odometry_.get();
  }
  battery_ = std::make_unique<agent_service::BatteryTap>(*odometry_);
  odometry_ = battery_.get();
  if (correction == core::SensorCorrection()) return;
  corrected_laser_ =
      std::make_unique<core::CorrectedLaser>(*laser_, correction);
  corrected_odometry_ =
      std::make_unique<core::CorrectedOdometry>(*odometry_, correction);
  laser_ = corrected_laser_.get();
  odometry_ = corrected_odometry_.get();
}

core::RgbdCamera& WatchedSensors::Corrected(core::RgbdCamera& camera) {
  corrected_camera_ =
      std::make_unique<core::CorrectedCamera>(camera, correction_);
  return *corrected_camera_;
}

}  // namespace treeline::run_app
