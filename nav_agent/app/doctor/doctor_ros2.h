// Looks at a robot that speaks ROS 2.
#ifndef NAV_AGENT_APP_DOCTOR_DOCTOR_ROS2_H_
#define NAV_AGENT_APP_DOCTOR_DOCTOR_ROS2_H_

#include <stop_token>
#include <string>
#include <vector>

#include "nav_agent/app/doctor/doctor.h"

namespace treeline::doctor_app {

// The robot of the file at `path` (docs/reference/ros2-robot.md): whether it is
// heard, where its sensors are, how often they speak, who listens to its
// velocities. Waits for it for `listen_s`, and then listens as long. No
// velocity is published: the robot does not move.
std::vector<Finding> ExamineRos2(const std::string& path, double listen_s,
                                 const std::stop_token& stop);

}  // namespace treeline::doctor_app

#endif  // NAV_AGENT_APP_DOCTOR_DOCTOR_ROS2_H_
