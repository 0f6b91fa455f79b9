// A recording of ROS as entries of an agent's log.
#ifndef NAV_AGENT_ROS_LOG_BAG_TO_LOG_H_
#define NAV_AGENT_ROS_LOG_BAG_TO_LOG_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/ros2/bag/bag.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::ros_log {

// Empty: the topic of log_topics.h if it is there, else the one with the most
// messages of its type.
struct BagLogOptions {
  std::string scan_topic{};      // sensor_msgs/LaserScan
  std::string odometry_topic{};  // nav_msgs/Odometry
  // Pictures only if named, or there as log_topics.h has them.
  std::string color_topic{};
  std::string depth_topic{};
  bool with_frames = true;
};

using TakeEntry = std::function<absl::Status(recording::LogEntry)>;

struct BagLog {
  int64_t scans = 0;
  int64_t readings = 0;
  int64_t frames = 0;
  // What was taken for granted or left out, a sentence each.
  std::vector<std::string> notes;
};

// Reads the bag twice: frames and topics, then what is measured, in the bag's
// order. Wheel readings are what /joint_states says of our wheels, or else
// those that make the odometry's poses, on the wheel track of /robot_measures
// or of the default robot. INVALID_ARGUMENT: there is no scan, or a topic is
// not there; lists the topics. What `take` returns, if it is an error.
absl::StatusOr<BagLog> ReadBagAsLog(bag::Bag& bag, const BagLogOptions& options,
                                    const TakeEntry& take);

}  // namespace treeline::ros_log

#endif  // NAV_AGENT_ROS_LOG_BAG_TO_LOG_H_
