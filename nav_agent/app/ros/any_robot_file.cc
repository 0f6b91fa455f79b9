#include "nav_agent/app/ros/any_robot_file.h"

#include <algorithm>
#include <array>

#include "absl/strings/match.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/yaml/yaml_node.h"
#include "nav_agent/app/hardware/robot_hardware.h"
#include "nav_agent/app/ros/ros_robot_config.h"

namespace treeline::ros_app {
namespace {

constexpr size_t kMaxFileBytes = 65536;
// A file of --ros2 has one of these; the other kinds have none.
constexpr std::array<const char*, 12> kRosKeys = {
    "domain_id", "rmw",  "interface", "use_sim_time", "node_name", "remap",
    "scan",      "odom", "cmd_vel",   "base_frame",   "map_frame", "namespace"};

constexpr std::array<const char*, 4> kHardwareCameraKeys = {
    "camera_x_m", "camera_y_m", "camera_z_m", "camera_down_rad"};

core::RobotDescription RobotOf(const RosRobotConfig& config,
                               const std::string& name) {
  core::RobotDescription robot = {.name = name,
                                  .model = config.robot,
                                  .lasers = {},
                                  .correction = config.correction,
                                  .noise = config.noise};
  if (config.base_from_laser.has_value()) {
    robot.model.base_from_laser = *config.base_from_laser;
  }
  if (config.base_from_rear_laser.has_value()) {
    robot.model.base_from_rear_laser = *config.base_from_rear_laser;
  }
  if (config.base_from_camera.has_value()) {
    robot.model.base_from_camera = *config.base_from_camera;
  }
  return robot;
}

RobotFileKind KindOf(const yaml::YamlNode& file) {
  if (file.Has("base")) return RobotFileKind::kHardware;
  const bool is_ros = std::ranges::any_of(
      kRosKeys, [&file](const char* key) { return file.Has(key); });
  return is_ros ? RobotFileKind::kRos : RobotFileKind::kRobot;
}

// "camera" is a place in a robot's file, and a device in one of hardware.
bool TellsCamera(const yaml::YamlNode& file, RobotFileKind kind) {
  switch (kind) {
    case RobotFileKind::kRobot:
      return file.Has("camera");
    case RobotFileKind::kHardware:
      return std::ranges::any_of(kHardwareCameraKeys, [&file](const char* key) {
        return file.Has(key);
      });
    case RobotFileKind::kRos:
      return file.Has("base_from_camera");
  }
  return false;
}

}  // namespace

absl::StatusOr<RobotFileKind> KindOfRobotFile(absl::string_view text,
                                              absl::string_view name) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode file,
                      yaml::YamlNode::Parse(text, name));
  return KindOf(file);
}

recording::LogCorrection AnyRobotFile::Correction() const {
  recording::LogCorrection correction = {.sensors = robot.correction,
                                         .robot = {}};
  if (kind != RobotFileKind::kRos) correction.robot = robot.model;
  return correction;
}

absl::StatusOr<AnyRobotFile> ReadAnyRobotFile(const std::string& name_or_path) {
  AnyRobotFile read;
  if (absl::EndsWith(name_or_path, ".yaml") ||
      absl::StrContains(name_or_path, "/")) {
    TL_ASSIGN_OR_RETURN(const std::string text,
                        base::ReadFile(name_or_path, kMaxFileBytes));
    TL_ASSIGN_OR_RETURN(const yaml::YamlNode file,
                        yaml::YamlNode::Parse(text, name_or_path));
    read.kind = KindOf(file);
    read.tells_camera = TellsCamera(file, read.kind);
  }
  if (read.kind == RobotFileKind::kHardware) {
    TL_ASSIGN_OR_RETURN(const hardware::HardwareConfig config,
                        hardware::ReadHardwareConfig(name_or_path));
    read.robot = {.name = name_or_path,
                  .model = config.robot,
                  .lasers = {},
                  .correction = config.correction,
                  .noise = config.noise};
  } else if (read.kind == RobotFileKind::kRos) {
    TL_ASSIGN_OR_RETURN(const RosRobotConfig config,
                        ReadRosRobotConfig(name_or_path));
    read.robot = RobotOf(config, name_or_path);
  } else {
    TL_ASSIGN_OR_RETURN(read.robot, core::ReadRobot(name_or_path));
  }
  return read;
}

absl::StatusOr<bridge_app::SensorsOfFile> ReadSensorsOfFile(
    const std::string& name_or_path) {
  TL_ASSIGN_OR_RETURN(const AnyRobotFile file, ReadAnyRobotFile(name_or_path));
  bridge_app::SensorsOfFile sensors = {
      .camera_delay_s = file.robot.correction.camera_delay_s,
      .laser_delay_s = file.robot.correction.laser_delay_s};
  if (file.tells_camera) {
    sensors.base_from_camera = file.robot.model.base_from_camera;
  }
  return sensors;
}

}  // namespace treeline::ros_app
