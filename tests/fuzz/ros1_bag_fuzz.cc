// Arbitrary bytes as a bag of ROS 1: opening and reading end, read within the
// bytes, and messages are decoded or refused.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "common/ros2/bag/ros1_bag.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"

namespace {

namespace bag = treeline::bag;
namespace messages = treeline::messages;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto opened =
      bag::ParseRos1Bag({reinterpret_cast<const char*>(data), size}, "bag");
  if (!opened.ok()) return 0;
  std::vector<bag::BagPlace> places;
  (void)(*opened)->Read([&](const bag::BagMessage& message) {
    const bag::BagTopic& topic = (*opened)->topics().at(message.topic);
    (void)bag::DecodeHeader(topic, message.bytes);
    (void)bag::Decode<messages::LaserScan>(topic, message.bytes);
    (void)bag::Decode<messages::Odometry>(topic, message.bytes);
    (void)bag::Decode<messages::TFMessage>(topic, message.bytes);
    (void)bag::Decode<messages::CameraInfo>(topic, message.bytes);
    places.push_back(message.place);
    return absl::OkStatus();
  });
  for (const bag::BagPlace& place : places) {
    if (!(*opened)->Fetch(place).ok()) std::abort();
  }
  return 0;
}
