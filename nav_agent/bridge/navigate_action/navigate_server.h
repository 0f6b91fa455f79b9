// Nav2's action NavigateToPose among the nodes of ROS 2: its three services and
// two topics.
#ifndef NAV_AGENT_BRIDGE_NAVIGATE_ACTION_NAVIGATE_SERVER_H_
#define NAV_AGENT_BRIDGE_NAVIGATE_ACTION_NAVIGATE_SERVER_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/bridge/dds/node.h"
#include "nav_agent/bridge/dds/service.h"
#include "nav_agent/bridge/navigate_action/navigate_action.h"

namespace treeline::navigate_action {

// How services are offered: dds::Node::Serve, or another implementation's.
using Serve = std::function<absl::StatusOr<std::unique_ptr<dds::Service>>(
    const std::string& service, const std::string& service_type)>;

// For one thread.
class NavigateServer {
 public:
  // A line for a log.
  using Warn = std::function<void(const std::string& line)>;

  // action: "navigate_to_pose", as a topic is named. The node must outlive it.
  static absl::StatusOr<std::unique_ptr<NavigateServer>> Open(
      dds::Node& node, const Serve& serve, const std::string& action,
      ActionAgent agent, Warn warn);

  // Takes requests and answers them. Those for results are answered when there
  // are some; of more than 256 that wait, the oldest are forgotten.
  void Answer(const Moment& moment);
  // Tells what has become of goals. Errors: of DDS.
  absl::Status Tell(const agent_service::AgentState& state,
                    const Moment& moment, const std::string& map_frame);
  // The agent ends: so does its goal, and who waits for its result hears it.
  void Close(const Moment& moment);

 private:
  struct Waiting {
    dds::RequestId id;
    messages::Uuid goal_id;
  };

  NavigateServer(ActionAgent agent, Warn warn)
      : action_(std::move(agent)), warn_(std::move(warn)) {}
  void AnswerGoals(const Moment& moment);
  void AnswerCancels();
  void TakeResultRequests();
  void SendResults();
  absl::Status PublishStatuses();
  void WarnOf(const dds::Service& service, const absl::Status& status);
  void WarnOfOthers();

  NavigateAction action_;
  const Warn warn_;
  std::unique_ptr<dds::Service> send_goal_;
  std::unique_ptr<dds::Service> cancel_goal_;
  std::unique_ptr<dds::Service> get_result_;
  std::unique_ptr<dds::Publisher> feedback_;
  std::unique_ptr<dds::Publisher> status_;
  std::deque<Waiting> waiting_;
  bool has_warned_of_others_ = false;
};

}  // namespace treeline::navigate_action

#endif  // NAV_AGENT_BRIDGE_NAVIGATE_ACTION_NAVIGATE_SERVER_H_
