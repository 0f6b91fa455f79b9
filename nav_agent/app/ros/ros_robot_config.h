// A robot of ROS 2: its topics, its frames, its measures.
#ifndef NAV_AGENT_APP_ROS_ROS_ROBOT_CONFIG_H_
#define NAV_AGENT_APP_ROS_ROS_ROBOT_CONFIG_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/bridge/dds/domain.h"
#include "nav_agent/bridge/dds/topic_names.h"
#include "nav_agent/core/robot_file.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::ros_app {

// Whose services are spoken. ROS 2's own do not understand each other.
enum class Rmw {
  // rmw_fastrtps_cpp, which ROS 2 comes with.
  kFastDds,
  // rmw_cyclonedds_cpp.
  kCyclone
};

struct RosRobotConfig {
  // ---- who is met, and how ----
  dds::DomainOptions domain;
  Rmw rmw = Rmw::kFastDds;
  dds::NodeName node;
  bool use_sim_time = false;
  // ---- what the robot says; "": there is none ----
  std::string scan = "scan";
  std::string rear_scan;
  std::string odom = "odom";
  std::string battery;
  std::string image;
  std::string camera_info;
  std::string depth;
  bool reliable_pictures = false;
  bool is_rectified = false;
  // Pictures in a second that are decoded.
  double picture_hz = 5;
  // ---- what it is told ----
  std::string cmd_vel = "cmd_vel";
  bool is_cmd_vel_stamped = false;
  // ---- what others are told, and may ask ----
  std::string map = "map";
  std::string plan = "plan";
  std::string pose = "amcl_pose";
  std::string goal = "goal_pose";
  std::string navigate_to_pose = "navigate_to_pose";
  std::string initial_pose = "initialpose";
  bool publishes_tf = true;
  // How far ahead of its moment map_frame to odom is stamped (s), so that
  // others find it until the next one comes.
  double tf_tolerance_s = 0.3;
  // ---- frames ----
  std::string map_frame = "map";
  std::string base_frame = "base_footprint";
  // nullopt: /tf_static tells.
  std::optional<geometry::Rigid3> base_from_laser;
  std::optional<geometry::Rigid3> base_from_rear_laser;
  std::optional<geometry::Rigid3> base_from_camera;
  // ---- its measures; where its sensors are is found out ----
  core::RobotModel robot;
  // What it says is corrected by this before it is used.
  core::SensorCorrection correction;
  // nullopt: nobody measured it.
  std::optional<core::MeasuredOdometryNoise> noise;
  core::ContactEnd contacts = core::ContactEnd::kUnsaid;

  absl::Status Validate() const;
};

// A YAML file (docs/reference/ros2-robot.md). INVALID_ARGUMENT names file, line
// and the key that was probably meant.
absl::StatusOr<RosRobotConfig> ReadRosRobotConfig(const std::string& path);

}  // namespace treeline::ros_app

#endif  // NAV_AGENT_APP_ROS_ROS_ROBOT_CONFIG_H_
