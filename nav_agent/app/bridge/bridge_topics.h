// The topics of a place finder, over DDS.
#ifndef NAV_AGENT_APP_BRIDGE_BRIDGE_TOPICS_H_
#define NAV_AGENT_APP_BRIDGE_BRIDGE_TOPICS_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "nav_agent/app/bridge/bridge_config.h"
#include "nav_agent/bridge/dds/node.h"
#include "nav_agent/bridge/place_finder/place_finder.h"
#include "nav_agent/bridge/topic_inputs/topic_inputs.h"

namespace treeline::bridge_app {

// Time as ROS 2 has it: of the system, or of /clock. By one thread.
class RosClock final : public base::Clock {
 public:
  explicit RosClock(bool is_simulated) : is_simulated_(is_simulated) {}
  // Simulated time begins with the first message of /clock; 0 before.
  base::MonotonicTime Now() const override;
  void Set(const messages::Clock& clock);
  bool is_simulated() const { return is_simulated_; }

 private:
  bool is_simulated_;
  base::MonotonicTime simulated_;
};

class BridgeTopics {
 public:
  // Finder and clock get what comes; all must outlive it.
  static absl::StatusOr<std::unique_ptr<BridgeTopics>> Open(
      dds::Node& node, const BridgeConfig& config,
      place_finder::PlaceFinder& finder, RosClock& clock);

  topic_inputs::TopicInputs& inputs() { return inputs_; }
  absl::Status Publish(const messages::PoseWithCovarianceStamped& place);
  absl::Status Publish(const messages::DiagnosticArray& diagnostics);

 private:
  BridgeTopics(dds::Node& node, place_finder::PlaceFinder& finder)
      : inputs_(node), finder_(finder) {}
  absl::Status SubscribeCamera(const BridgeConfig& config);
  // What is handed to the place finder as it is.
  template <typename M>
  absl::Status Subscribe(const std::string& topic, const dds::Quality& quality);

  topic_inputs::TopicInputs inputs_;
  place_finder::PlaceFinder& finder_;
  std::unique_ptr<dds::Publisher> place_;
  std::unique_ptr<dds::Publisher> diagnostics_;
};

}  // namespace treeline::bridge_app

#endif  // NAV_AGENT_APP_BRIDGE_BRIDGE_TOPICS_H_
