// A robot behind topics of ROS 2, as the agent's ports.
#ifndef NAV_AGENT_APP_ROS_ROS_ROBOT_H_
#define NAV_AGENT_APP_ROS_ROS_ROBOT_H_

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "common/ros2/conversions/frame_tree.h"
#include "nav_agent/app/ros/ros_robot_config.h"
#include "nav_agent/bridge/agent_report/agent_report.h"
#include "nav_agent/bridge/dds/domain.h"
#include "nav_agent/bridge/dds/node.h"
#include "nav_agent/bridge/robot_ports/base_port.h"
#include "nav_agent/bridge/robot_ports/battery_port.h"
#include "nav_agent/bridge/robot_ports/camera_port.h"
#include "nav_agent/bridge/robot_ports/laser_port.h"
#include "nav_agent/bridge/robot_ports/odometry_port.h"
#include "nav_agent/bridge/robot_ports/ros_time.h"
#include "nav_agent/bridge/topic_inputs/topic_inputs.h"

namespace treeline::ros_app {

// A thread of its own hands over what comes. The ports are thread-safe, and
// valid for as long as this is.
class RosRobot {
 public:
  // For a log: a warning.
  using Warn = std::function<void(const std::string& line)>;

  // warn: called by any thread. drives: whether it may be told to move; if not,
  // nothing is published. Errors: as dds::Domain::Join; INVALID_ARGUMENT for
  // names of topics.
  static absl::StatusOr<std::unique_ptr<RosRobot>> Open(
      const RosRobotConfig& config, bool drives, const base::Clock& real_clock,
      Warn warn);
  // The robot stands.
  ~RosRobot();

  // Waits until the robot has said where its sensors are and what they are;
  // model() is whole afterwards. OK, too, when `stop` is requested.
  // FAILED_PRECONDITION: a laser is neither level nor upside down.
  absl::Status WaitUntilKnown(const std::stop_token& stop);
  // What is missing now for that, and why; "": nothing. Errors likewise. Not to
  // be called by two threads at once.
  absl::StatusOr<std::string> Missing();

  const core::RobotModel& model() const { return model_; }
  core::RangeSensor& laser() { return laser_; }
  // Null: there is none.
  core::RangeSensor* rear_laser() {
    return config_.rear_scan.empty() ? nullptr : &rear_laser_;
  }
  robot_ports::OdometryPort& odometry() { return odometry_; }
  core::BaseDriver& base() { return *base_; }
  core::RgbdCamera* camera() {
    return config_.image.empty() ? nullptr : &camera_;
  }
  // nullopt: it tells none.
  std::optional<core::Battery> battery() const { return battery_.battery(); }
  const robot_ports::RosTime& time() const { return time_; }

  const RosRobotConfig& config() const { return config_; }
  const dds::Domain& domain() const { return *domain_; }
  agent_report::TopicFacts Facts() const;
  // Of messages, from writing to delivery: topic_inputs.h.
  double Delivery_ms(double share) const;
  // Processor time of the thread that hands messages over; that of DDS's own
  // threads is not in it (s).
  double listening_s() const;

 private:
  RosRobot(const RosRobotConfig& config, const base::Clock& real_clock,
           Warn warn);
  absl::Status Subscribe();
  absl::Status SubscribeCamera();
  absl::Status AdvertiseBase(bool drives);
  absl::Status Send(const core::VelocityCommand& command);
  absl::Status SetClock(const messages::Clock& clock);
  absl::Status AddOdometry(const messages::Odometry& message);
  // Why nothing of use has come from a device, why nobody publishes `topic`
  // ("": somebody does), and why it is not known where a sensor is.
  std::string WhyNothing(const std::string& topic,
                         const core::DeviceHealth& health) const;
  std::string WhyNobody(const std::string& topic) const;
  std::string WhyNoMount(const std::string& frame) const;
  // nullopt: not known yet.
  std::optional<geometry::Rigid3> Mount(
      const std::optional<geometry::Rigid3>& given,
      const std::string& frame_id) const;
  absl::StatusOr<std::string> FindLaser(
      const std::string& topic, robot_ports::LaserPort& laser,
      const std::optional<geometry::Rigid3>& given,
      geometry::Rigid3& base_from_laser);
  absl::StatusOr<std::string> FindCamera();
  void Listen(const std::stop_token& stop);

  const RosRobotConfig config_;
  const base::Clock& real_clock_;
  const Warn warn_;
  core::RobotModel model_;
  robot_ports::RosTime time_;
  robot_ports::LaserPort laser_;
  robot_ports::LaserPort rear_laser_;
  robot_ports::OdometryPort odometry_;
  robot_ports::CameraPort camera_;
  robot_ports::BatteryPort battery_;
  mutable absl::Mutex mutex_;
  conversions::FrameTree frames_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<dds::Domain> domain_;
  std::unique_ptr<dds::Node> node_;
  std::unique_ptr<dds::Publisher> cmd_vel_;
  std::unique_ptr<robot_ports::BasePort> base_;
  // Found once: of the frame that odometry is of.
  std::optional<geometry::Rigid3> child_from_base_;
  mutable absl::Mutex inputs_mutex_;
  std::unique_ptr<topic_inputs::TopicInputs> inputs_
      ABSL_GUARDED_BY(inputs_mutex_);
  agent_report::TopicFacts facts_ ABSL_GUARDED_BY(mutex_);
  double listening_s_ ABSL_GUARDED_BY(mutex_) = 0;
  // The last member: it uses all of them.
  std::jthread thread_;
};

}  // namespace treeline::ros_app

#endif  // NAV_AGENT_APP_ROS_ROS_ROBOT_H_
