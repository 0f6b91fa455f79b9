// Files that describe a robot, of whichever kind.
#ifndef NAV_AGENT_APP_ROS_ANY_ROBOT_FILE_H_
#define NAV_AGENT_APP_ROS_ANY_ROBOT_FILE_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/app/bridge/bridge_config.h"
#include "nav_agent/core/robot_file.h"
#include "nav_agent/recording/log_correction.h"

namespace treeline::ros_app {

enum class RobotFileKind : uint8_t {
  kRobot,     // docs/reference/robots.md
  kHardware,  // of --hardware: names a base
  kRos        // of --ros2: names topics, frames or a domain
};

// Of a file's text; INVALID_ARGUMENT if it is no YAML. `name`: for errors.
absl::StatusOr<RobotFileKind> KindOfRobotFile(absl::string_view text,
                                              absl::string_view name);

struct AnyRobotFile {
  RobotFileKind kind = RobotFileKind::kRobot;
  // Of a robot of ROS 2, sensors are where the file says; of those of which it
  // says nothing, the model does not tell.
  core::RobotDescription robot;
  // Whether the file itself says where the camera is; else the model's is that
  // of some robot.
  bool tells_camera = false;

  // Of recordings. A robot of ROS 2 told there itself where its sensors are.
  recording::LogCorrection Correction() const;
};

// One of core::RobotNames(), or a file: ends in .yaml or contains a '/'. The
// errors of those who read each kind.
absl::StatusOr<AnyRobotFile> ReadAnyRobotFile(const std::string& name_or_path);

// What a relocalizer takes of it.
absl::StatusOr<bridge_app::SensorsOfFile> ReadSensorsOfFile(
    const std::string& name_or_path);

}  // namespace treeline::ros_app

#endif  // NAV_AGENT_APP_ROS_ANY_ROBOT_FILE_H_
