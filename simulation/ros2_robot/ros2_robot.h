// A simulated robot that speaks ROS 2, and is known over DDS alone: for whoever
// has no robot at hand, and for tests.
#ifndef SIMULATION_ROS2_ROBOT_ROS2_ROBOT_H_
#define SIMULATION_ROS2_ROBOT_ROS2_ROBOT_H_

#include <cstdint>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "nav_agent/bridge/dds/domain.h"
#include "nav_agent/bridge/dds/topic_names.h"

namespace treeline::ros2_robot {

struct Ros2RobotOptions {
  // As in simulator/scenario.h.
  std::string world = "cafe";
  bool has_people = false;
  uint64_t seed = 1;
  dds::DomainOptions domain;
  // Of its topics; /tf_static and /clock have none.
  dds::NodeName node = {.node = "robot"};
  // Simulated seconds in a real one, told on /clock; 0: real time, with stamps
  // of the system's clock and without /clock.
  double pace = 1;
  // 0: no camera.
  double camera_hz = 0;
  // One laser of 541 beams at 20 Hz, as small robots have, rather than two of
  // which the first has 1081 at 40 Hz.
  bool is_plain = false;

  absl::Status Validate() const;
};

// Plays the robot until a stop is requested: it publishes what its sensors
// say, and drives as cmd_vel says. Takes orders from standard input
// (robot_orders.h). Twice a second a line of key=value is printed: where it is,
// and what it heard of whoever drives it. Errors: of the options, the world, or
// DDS.
absl::Status PlayRos2Robot(const Ros2RobotOptions& options,
                           const std::stop_token& stop);

}  // namespace treeline::ros2_robot

#endif  // SIMULATION_ROS2_ROBOT_ROS2_ROBOT_H_
