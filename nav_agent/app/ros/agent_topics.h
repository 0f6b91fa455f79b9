// The agent among the nodes of ROS 2: what it tells them, and what they ask.
#ifndef NAV_AGENT_APP_ROS_AGENT_TOPICS_H_
#define NAV_AGENT_APP_ROS_AGENT_TOPICS_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/app/ros/ros_robot.h"
#include "nav_agent/bridge/fast_dds/fast_services.h"
#include "nav_agent/bridge/navigate_action/navigate_server.h"
#include "nav_agent/service/agent_commands.h"

namespace treeline::ros_app {

// Publishes map, plan, place, map_frame to odom and diagnostics; takes goals,
// initial poses, ~/cancel and ~/find_yourself; serves NavigateToPose. In a
// thread of its own, which ends with it.
class AgentTopics {
 public:
  // All must outlive it, and hub and commands be stepped. Errors: of DDS.
  static absl::StatusOr<std::unique_ptr<AgentTopics>> Start(
      RosRobot& robot, agent_service::AgentCommands& commands,
      RosRobot::Warn warn);
  ~AgentTopics();

 private:
  AgentTopics(RosRobot& robot, agent_service::AgentCommands& commands,
              RosRobot::Warn warn)
      : robot_(robot), commands_(commands), warn_(std::move(warn)) {}
  absl::Status Advertise();
  absl::Status Subscribe();
  absl::Status ServeActions();
  absl::StatusOr<uint64_t> SetGoal(const messages::PoseStamped& goal);
  absl::Status TakePlace(const messages::PoseWithCovarianceStamped& place);
  // In the map, on the ground that is nearest in height. INVALID_ARGUMENT.
  absl::StatusOr<agent_service::RequestedPose> RequestedOf(
      const messages::Header& header, const messages::Pose& pose) const;
  void Run(const std::stop_token& stop);
  absl::Status Publish(const agent_service::AgentState& state);
  absl::Status PublishPlace(const localization::TrackedPose& pose);
  absl::Status PublishMap(int level);
  absl::Status PublishReport(const agent_service::AgentState& state);
  messages::Header InMap(base::MonotonicTime stamp) const;
  navigate_action::Moment Now() const;

  RosRobot& robot_;
  agent_service::AgentCommands& commands_;
  const RosRobot::Warn warn_;
  std::unique_ptr<dds::Node> node_;
  std::unique_ptr<dds::Publisher> map_;
  std::unique_ptr<dds::Publisher> plan_;
  std::unique_ptr<dds::Publisher> pose_;
  std::unique_ptr<dds::Publisher> frames_;
  std::unique_ptr<dds::Publisher> diagnostics_;
  std::unique_ptr<topic_inputs::TopicInputs> inputs_;
  // Null: services are those of node_.
  std::unique_ptr<fast_dds::FastServices> fast_services_;
  // Null: none is to be served.
  std::unique_ptr<navigate_action::NavigateServer> navigate_;
  // ---- what was published last ----
  std::optional<int> level_;
  std::vector<core::LevelPose> path_;
  std::optional<base::MonotonicTime> place_stamp_;
  std::optional<behavior::NavigatorMode> mode_;
  base::MonotonicTime next_report_;
  // The last member: it uses all of them.
  std::jthread thread_;
};

}  // namespace treeline::ros_app

#endif  // NAV_AGENT_APP_ROS_AGENT_TOPICS_H_
