// What a robot's file says against what its recordings say: those hold
// measurements uncorrected.
#ifndef NAV_AGENT_RECORDING_LOG_CORRECTION_H_
#define NAV_AGENT_RECORDING_LOG_CORRECTION_H_

#include <optional>

#include "nav_agent/core/robot_file.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::recording {

struct LogCorrection {
  core::SensorCorrection sensors;
  // Instead of the log's, where a file says more of it than the log does.
  std::optional<core::RobotModel> robot;

  bool IsNone() const {
    return sensors == core::SensorCorrection() && !robot.has_value();
  }
};

// One entry, as it is to be understood.
void Correct(const LogCorrection& correction, LogEntry& entry);

}  // namespace treeline::recording

#endif  // NAV_AGENT_RECORDING_LOG_CORRECTION_H_
