// A robot of ROS 2 that an agent drives.
#ifndef NAV_AGENT_APP_RUN_ROS_AGENT_ROBOT_H_
#define NAV_AGENT_APP_RUN_ROS_AGENT_ROBOT_H_

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "nav_agent/app/ros/ros_robot.h"
#include "nav_agent/app/run/agent_robot.h"

namespace treeline::run_app {

class RosAgentRobot final : public AgentRobot {
 public:
  // config_path: ReadRosRobotConfig's. announce: told the domain, for scripts.
  // Errors as it and RosRobot::Open.
  static absl::StatusOr<std::unique_ptr<RosAgentRobot>> Open(
      const std::string& config_path, const base::Clock& real_clock,
      ros_app::RosRobot::Warn warn,
      const std::function<void(const std::string& line)>& announce);

  ros_app::RosRobot& robot() { return *robot_; }

  behavior::NavigatorDevices Devices() override {
    return {.laser = robot_->laser(),
            .odometry = robot_->odometry(),
            .base = robot_->base(),
            .rear_laser = robot_->rear_laser(),
            .camera = robot_->camera()};
  }
  const base::Clock& clock() const override { return robot_->time(); }
  std::optional<core::Battery> Battery() const override {
    return robot_->battery();
  }
  // Whole once RosRobot::WaitUntilKnown has returned.
  const core::RobotModel& model() const override { return robot_->model(); }
  core::SensorCorrection correction() const override {
    return robot_->config().correction;
  }
  std::optional<core::MeasuredOdometryNoise> noise() const override {
    return robot_->config().noise;
  }
  core::ContactEnd contacts() const override {
    return robot_->config().contacts;
  }
  // Time passes by itself. Of a simulation it is waited for: steps are taken at
  // its pace, whatever that is.
  void Advance(std::chrono::nanoseconds duration) override;

 private:
  explicit RosAgentRobot(std::unique_ptr<ros_app::RosRobot> robot)
      : robot_(std::move(robot)) {}

  const std::unique_ptr<ros_app::RosRobot> robot_;
  base::MonotonicTime due_;
};

}  // namespace treeline::run_app

#endif  // NAV_AGENT_APP_RUN_ROS_AGENT_ROBOT_H_
