// What a recording of ROS holds that a capture can be made of, and which topics
// are taken.
#ifndef SERVER_TOOLS_CAPTURE_ROS_TOPICS_H_
#define SERVER_TOOLS_CAPTURE_ROS_TOPICS_H_

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/rigid3.h"
#include "common/ros2/bag/bag.h"
#include "common/ros2/conversions/transform_history.h"
#include "common/ros2/messages/sensor_messages.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

struct RosPicture {
  int64_t stamp_ns = 0;
  bag::BagPlace place;
};

struct RosPictureTopic {
  bag::BagTopic topic;
  bool is_compressed = false;
  // By what the first message says of its encoding.
  bool is_depth = false;
  std::string encoding;
  std::string frame;
  // By stamp; each later than the one before.
  std::vector<RosPicture> pictures;
};

struct RosCameraTopic {
  std::string name;
  // The first message.
  messages::CameraInfo info;
};

struct RosPoseTopic {
  std::string name;
  std::string type;
  std::string frame;
  // Of Odometry; else empty: the message does not say.
  std::string child_frame;
  std::vector<std::pair<int64_t, geometry::Rigid3>> poses;
};

// All that is small in a recording.
struct RosContents {
  std::vector<RosPictureTopic> pictures;
  std::vector<RosCameraTopic> cameras;
  std::vector<RosPoseTopic> poses;
  conversions::TransformHistory transforms;
  LeftOut left_out;
  // Where a broken recording ended.
  std::vector<std::string> notes;

  // The topics, a line each, for errors.
  std::string Listing() const;
};

absl::StatusOr<RosContents> ReadRosContents(bag::Bag& bag);

// The choices below: what `wanted` names, or else a guess. INVALID_ARGUMENT
// says what is missing and lists the topics.

// Guess: names with "color" or "rgb", then the most pictures, then those that
// are not compressed.
absl::StatusOr<const RosPictureTopic*> ChooseColor(const RosContents& contents,
                                                   const std::string& wanted);
// Null: there is none, or `wanted` is "none". Guess: the frame of colour, names
// with "aligned" or "registered", then as above.
absl::StatusOr<const RosPictureTopic*> ChooseDepth(const RosContents& contents,
                                                   const RosPictureTopic& color,
                                                   const std::string& wanted);
// Guess: camera_info beside the pictures' topic, else one of the same frame.
absl::StatusOr<const RosCameraTopic*> ChooseCamera(
    const RosContents& contents, const RosPictureTopic& pictures,
    const std::string& wanted, const char* flag);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_ROS_TOPICS_H_
