// Names of topics as ROS 2 makes them: namespaces, remapping, and what DDS
// sees of them (https://design.ros2.org/articles/topic_and_service_names.html).
#ifndef NAV_AGENT_BRIDGE_DDS_TOPIC_NAMES_H_
#define NAV_AGENT_BRIDGE_DDS_TOPIC_NAMES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::dds {

// "from:=to": what is written as `from`, or means the same, is `to` instead.
struct Remapping {
  std::string from;
  std::string to;
};

struct NodeName {
  // "" or "/": none. "/robot1", "robot1": of every relative name.
  std::string name_space = {};
  // Letters, digits and underscores; "~/x" is within it.
  std::string node = "treeline";
  std::vector<Remapping> remappings = {};
};

// INVALID_ARGUMENT unless it is "from:=to" with two names.
absl::StatusOr<Remapping> ParseRemapping(absl::string_view text);

// "scan" -> "/robot1/scan", then remapped; the first rule that fits is taken.
// INVALID_ARGUMENT for names that ROS 2 does not allow.
absl::StatusOr<std::string> FullTopicName(absl::string_view name,
                                          const NodeName& node);

// "/robot1/scan" -> "rt/robot1/scan".
std::string DdsTopicName(absl::string_view full_name);
// "/robot1/ask" -> "rq/robot1/askRequest", "rr/robot1/askReply".
std::string DdsRequestTopicName(absl::string_view full_name);
std::string DdsReplyTopicName(absl::string_view full_name);
// "sensor_msgs/msg/LaserScan" -> "sensor_msgs::msg::dds_::LaserScan_".
std::string DdsTypeName(absl::string_view message_name);

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_TOPIC_NAMES_H_
