#include "common/ros2/bag/bag.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"

namespace treeline::bag {
namespace {

absl::Status Unreadable(const BagTopic& topic) {
  return absl::InvalidArgumentError(absl::StrCat(
      topic.name, ": messages are neither CDR nor ROS 1's serialization"));
}

}  // namespace

size_t Bag::AddTopic(const BagTopic& topic) {
  const auto found = std::ranges::find(topics_, topic);
  if (found != topics_.end()) {
    return static_cast<size_t>(found - topics_.begin());
  }
  topics_.push_back(topic);
  return topics_.size() - 1;
}

std::string Ros2TypeName(absl::string_view type) {
  // Of the first tf; the same fields.
  if (type == "tf/tfMessage") return messages::TFMessage::kName;
  const size_t slash = type.find('/');
  if (slash == absl::string_view::npos ||
      type.find('/', slash + 1) != absl::string_view::npos) {
    return std::string(type);
  }
  return absl::StrCat(type.substr(0, slash), "/msg", type.substr(slash));
}

template <messages::Message M>
absl::StatusOr<M> Decode(const BagTopic& topic,
                         std::span<const uint8_t> bytes) {
  if (topic.type != M::kName) {
    return absl::InvalidArgumentError(absl::StrCat(
        topic.name, ": is of type ", topic.type, ", not ", M::kName));
  }
  if (topic.serialization == Serialization::kOther) return Unreadable(topic);
  auto message = topic.serialization == Serialization::kCdr
                     ? messages::Decode<M>(bytes)
                     : messages::DecodeRos1<M>(bytes);
  if (!message.ok()) return base::Annotate(message.status(), topic.name);
  return message;
}

absl::StatusOr<messages::Header> DecodeHeader(const BagTopic& topic,
                                              std::span<const uint8_t> bytes) {
  if (topic.serialization == Serialization::kOther) return Unreadable(topic);
  auto header = topic.serialization == Serialization::kCdr
                    ? messages::DecodeHeader(bytes)
                    : messages::DecodeHeaderRos1(bytes);
  if (!header.ok()) return base::Annotate(header.status(), topic.name);
  return header;
}

template absl::StatusOr<messages::PoseStamped> Decode(const BagTopic&,
                                                      std::span<const uint8_t>);
template absl::StatusOr<messages::PoseWithCovarianceStamped> Decode(
    const BagTopic&, std::span<const uint8_t>);
template absl::StatusOr<messages::TransformStamped> Decode(
    const BagTopic&, std::span<const uint8_t>);
template absl::StatusOr<messages::TFMessage> Decode(const BagTopic&,
                                                    std::span<const uint8_t>);
template absl::StatusOr<messages::LaserScan> Decode(const BagTopic&,
                                                    std::span<const uint8_t>);
template absl::StatusOr<messages::Image> Decode(const BagTopic&,
                                                std::span<const uint8_t>);
template absl::StatusOr<messages::CompressedImage> Decode(
    const BagTopic&, std::span<const uint8_t>);
template absl::StatusOr<messages::CameraInfo> Decode(const BagTopic&,
                                                     std::span<const uint8_t>);
template absl::StatusOr<messages::Odometry> Decode(const BagTopic&,
                                                   std::span<const uint8_t>);
template absl::StatusOr<messages::String> Decode(const BagTopic&,
                                                 std::span<const uint8_t>);
template absl::StatusOr<messages::Bool> Decode(const BagTopic&,
                                               std::span<const uint8_t>);
template absl::StatusOr<messages::Float64> Decode(const BagTopic&,
                                                  std::span<const uint8_t>);
template absl::StatusOr<messages::JointState> Decode(const BagTopic&,
                                                     std::span<const uint8_t>);
template absl::StatusOr<messages::Imu> Decode(const BagTopic&,
                                              std::span<const uint8_t>);
template absl::StatusOr<messages::Twist> Decode(const BagTopic&,
                                                std::span<const uint8_t>);
template absl::StatusOr<messages::TwistStamped> Decode(
    const BagTopic&, std::span<const uint8_t>);
template absl::StatusOr<messages::Log> Decode(const BagTopic&,
                                              std::span<const uint8_t>);

}  // namespace treeline::bag
