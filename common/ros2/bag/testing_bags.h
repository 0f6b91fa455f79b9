// For tests: bags of every kind, written apart from the readers.
#ifndef COMMON_ROS2_BAG_TESTING_BAGS_H_
#define COMMON_ROS2_BAG_TESTING_BAGS_H_

#include <cstdint>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/message_codec.h"
#include "common/ros2/messages/message_schema.h"

namespace treeline::bag {

struct TestingMessage {
  std::string topic;
  std::string type;
  std::string schema;
  int64_t time_ns = 0;
  std::vector<uint8_t> cdr;
  // The same in ROS 1's serialization.
  std::vector<uint8_t> ros1;
};

// ---- bytes of ROS 1 ----

template <typename T>
void PutRos1(const T& value, std::vector<uint8_t>& to) {
  if constexpr (std::is_same_v<T, messages::Header>) {
    PutRos1(uint32_t{7}, to);
  }
  if constexpr (messages::Message<T>) {
    std::apply([&](auto... field) { (PutRos1(value.*field.member, to), ...); },
               T::Fields());
  } else if constexpr (std::is_arithmetic_v<T>) {
    const auto* raw = reinterpret_cast<const uint8_t*>(&value);
    to.insert(to.end(), raw, raw + sizeof(T));
  } else {
    if constexpr (!messages::kIsArray<T>) {
      PutRos1(static_cast<uint32_t>(value.size()), to);
    }
    for (const auto& element : value) PutRos1(element, to);
  }
}

template <messages::Message M>
TestingMessage Recorded(const std::string& topic, int64_t time_ns,
                        const M& message) {
  TestingMessage made = {.topic = topic,
                         .type = M::kName,
                         .schema = messages::SchemaText<M>(),
                         .time_ns = time_ns,
                         .cdr = messages::Encode(message),
                         .ros1 = {}};
  PutRos1(message, made.ros1);
  return made;
}

// ---- files; a failure ends the program ----

// packing: "", "lz4" or "zstd".
void WriteMcapBag(const std::vector<TestingMessage>& messages,
                  const std::string& packing, const std::string& path);
void WriteSqliteBag(const std::vector<TestingMessage>& messages,
                    const std::string& path);
// packing: "none", "bz2" or "lz4". Without an index it is as a killed recorder
// leaves it.
void WriteRos1Bag(const std::vector<TestingMessage>& messages,
                  const std::string& packing, bool has_index,
                  const std::string& path);
// A folder of `ros2 bag record`, its messages in two files. storage: "mcap" or
// "sqlite3".
void WriteBagFolder(const std::vector<TestingMessage>& messages,
                    const std::string& storage, const std::string& folder);

}  // namespace treeline::bag

#endif  // COMMON_ROS2_BAG_TESTING_BAGS_H_
