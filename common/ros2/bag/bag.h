// Recordings of ROS as one kind of value, whatever file they are in: topics,
// and messages as bytes.
#ifndef COMMON_ROS2_BAG_BAG_H_
#define COMMON_ROS2_BAG_BAG_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/ros2/messages/message_codec.h"

namespace treeline::bag {

enum class Serialization : uint8_t { kCdr, kRos1, kOther };

struct BagTopic {
  // "/camera/image_raw".
  std::string name;
  // By its name in ROS 2, "sensor_msgs/msg/Image"; ROS 1's, too.
  std::string type;
  Serialization serialization = Serialization::kCdr;

  bool operator==(const BagTopic&) const = default;
};

// Where a message is, for reading it again.
struct BagPlace {
  uint32_t file = 0;
  uint32_t chunk = 0;
  uint64_t offset = 0;
};

struct BagMessage {
  // An index into topics().
  size_t topic = 0;
  // When it was recorded: nanoseconds since 1970, or of a simulation's clock.
  int64_t time_ns = 0;
  // Valid during the call that hands it over.
  std::span<const uint8_t> bytes;
  BagPlace place;
};

using TakeMessage = std::function<absl::Status(const BagMessage&)>;

// Implementations are safe on any bytes. Not thread-safe.
class Bag {
 public:
  virtual ~Bag() = default;
  const std::vector<BagTopic>& topics() const { return topics_; }

  // False: whoever recorded it did not close it, so that its end is missing.
  virtual bool is_closed() const { return true; }

  // Hands over all messages, in about the order of time. DATA_LOSS for what is
  // broken, with its place in the file; what `take` returns, if it is an error.
  virtual absl::Status Read(const TakeMessage& take) = 0;
  // The bytes of a message that Read has handed over, until the next call.
  virtual absl::StatusOr<std::span<const uint8_t>> Fetch(
      const BagPlace& place) = 0;

 protected:
  // Its index; a new one for a topic that is not there yet.
  size_t AddTopic(const BagTopic& topic);

 private:
  std::vector<BagTopic> topics_;
};

// "sensor_msgs/Image" -> "sensor_msgs/msg/Image"; other names as they are.
std::string Ros2TypeName(absl::string_view type);

// INVALID_ARGUMENT names the topic: it is of another type, or broken.
template <messages::Message M>
absl::StatusOr<M> Decode(const BagTopic& topic, std::span<const uint8_t> bytes);
// The header of any message that begins with one.
absl::StatusOr<messages::Header> DecodeHeader(const BagTopic& topic,
                                              std::span<const uint8_t> bytes);

}  // namespace treeline::bag

#endif  // COMMON_ROS2_BAG_BAG_H_
