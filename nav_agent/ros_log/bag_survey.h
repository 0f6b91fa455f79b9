// What a recording of ROS holds, found in a first pass, and the topics that are
// taken.
#ifndef NAV_AGENT_ROS_LOG_BAG_SURVEY_H_
#define NAV_AGENT_ROS_LOG_BAG_SURVEY_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/ros2/bag/bag.h"
#include "common/ros2/conversions/transform_history.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/ros_log/bag_to_log.h"

namespace treeline::ros_log {

// Topics are indices into bag::Bag::topics().
struct BagSurvey {
  // Messages a topic.
  std::vector<int64_t> counts;
  // When the first was recorded.
  int64_t first_ns = 0;
  conversions::TransformHistory transforms;
  // The first of each topic, by its name.
  std::map<std::string, messages::CameraInfo> cameras;
  core::RobotModel robot;
  bool has_robot = false;
  // Of the first message that has one.
  std::map<size_t, std::string> frames;
  // What odometry tells the pose of.
  std::map<size_t, std::string> base_frames;
  // By stamp (ns).
  std::map<size_t, std::map<int64_t, bag::BagPlace>> pictures;
  std::vector<std::string> notes;

  std::string FrameOf(const std::optional<size_t>& topic) const;
  // "base_link" without odometry.
  std::string BaseFrame(const std::optional<size_t>& odometry) const;
};

absl::StatusOr<BagSurvey> SurveyBag(bag::Bag& bag);

struct BagTopics {
  std::optional<size_t> scan;
  std::optional<size_t> odometry;
  std::optional<size_t> color;
  std::optional<size_t> depth;
};

// INVALID_ARGUMENT lists the topics: one that is named is not there, or there
// are neither scans nor pictures.
absl::StatusOr<BagTopics> ChooseTopics(const bag::Bag& bag,
                                       const BagLogOptions& options,
                                       const BagSurvey& survey);

}  // namespace treeline::ros_log

#endif  // NAV_AGENT_ROS_LOG_BAG_SURVEY_H_
