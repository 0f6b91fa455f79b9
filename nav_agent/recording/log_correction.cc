#include "nav_agent/recording/log_correction.h"

#include <variant>

#include "nav_agent/core/corrected_devices.h"

namespace treeline::recording {

void Correct(const LogCorrection& correction, LogEntry& entry) {
  if (auto* robot = std::get_if<core::RobotModel>(&entry)) {
    if (correction.robot.has_value()) *robot = *correction.robot;
  } else if (auto* scan = std::get_if<core::LaserScan>(&entry)) {
    scan->stamp -= core::DelayOf(correction.sensors.laser_delay_s);
  } else if (auto* reading = std::get_if<core::BaseReading>(&entry)) {
    core::Correct(correction.sensors, *reading);
  } else if (auto* frame = std::get_if<LogFrame>(&entry)) {
    frame->stamp -= core::DelayOf(correction.sensors.camera_delay_s);
  }
}

}  // namespace treeline::recording
