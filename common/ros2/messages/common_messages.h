// Messages of builtin_interfaces, std_msgs, rosgraph_msgs, rcl_interfaces and
// diagnostic_msgs.
#ifndef COMMON_ROS2_MESSAGES_COMMON_MESSAGES_H_
#define COMMON_ROS2_MESSAGES_COMMON_MESSAGES_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "common/ros2/messages/message_fields.h"

namespace treeline::messages {

// Since 1970, or of a simulation's clock. nanosec is below 1e9.
struct Time {
  int32_t sec = 0;
  uint32_t nanosec = 0;

  constexpr bool operator==(const Time&) const = default;
  static constexpr char kName[] = "builtin_interfaces/msg/Time";
  static constexpr auto Fields() {
    return std::make_tuple(Named("sec", &Time::sec),
                           Named("nanosec", &Time::nanosec));
  }
};

inline int64_t Nanoseconds(const Time& time) {
  return int64_t{time.sec} * 1'000'000'000 + time.nanosec;
}
inline Time TimeOf(int64_t nanoseconds) {
  int64_t seconds = nanoseconds / 1'000'000'000;
  int64_t rest = nanoseconds % 1'000'000'000;
  if (rest < 0) {
    rest += 1'000'000'000;
    --seconds;
  }
  return {static_cast<int32_t>(seconds), static_cast<uint32_t>(rest)};
}

struct Header {
  Time stamp;
  std::string frame_id;

  bool operator==(const Header&) const = default;
  static constexpr char kName[] = "std_msgs/msg/Header";
  static constexpr auto Fields() {
    return std::make_tuple(Named("stamp", &Header::stamp),
                           Named("frame_id", &Header::frame_id));
  }
};

// ROS 2 gives a message without fields one, which is always 0.
struct Empty {
  uint8_t structure_needs_at_least_one_member = 0;

  bool operator==(const Empty&) const = default;
  static constexpr char kName[] = "std_msgs/msg/Empty";
  static constexpr auto Fields() {
    return std::make_tuple(Named("structure_needs_at_least_one_member",
                                 &Empty::structure_needs_at_least_one_member));
  }
};

struct String {
  std::string data;

  bool operator==(const String&) const = default;
  static constexpr char kName[] = "std_msgs/msg/String";
  static constexpr auto Fields() {
    return std::make_tuple(Named("data", &String::data));
  }
};

struct Bool {
  bool data = false;

  bool operator==(const Bool&) const = default;
  static constexpr char kName[] = "std_msgs/msg/Bool";
  static constexpr auto Fields() {
    return std::make_tuple(Named("data", &Bool::data));
  }
};

struct Float64 {
  double data = 0;

  bool operator==(const Float64&) const = default;
  static constexpr char kName[] = "std_msgs/msg/Float64";
  static constexpr auto Fields() {
    return std::make_tuple(Named("data", &Float64::data));
  }
};

// A line of /rosout.
struct Log {
  static constexpr uint8_t kInfo = 20;

  Time stamp;
  uint8_t level = kInfo;
  std::string name;
  std::string msg;
  std::string file;
  std::string function;
  uint32_t line = 0;

  bool operator==(const Log&) const = default;
  static constexpr char kName[] = "rcl_interfaces/msg/Log";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("stamp", &Log::stamp), Named("level", &Log::level),
        Named("name", &Log::name), Named("msg", &Log::msg),
        Named("file", &Log::file), Named("function", &Log::function),
        Named("line", &Log::line));
  }
};

struct Clock {
  Time clock;

  bool operator==(const Clock&) const = default;
  static constexpr char kName[] = "rosgraph_msgs/msg/Clock";
  static constexpr auto Fields() {
    return std::make_tuple(Named("clock", &Clock::clock));
  }
};

struct KeyValue {
  std::string key;
  std::string value;

  bool operator==(const KeyValue&) const = default;
  static constexpr char kName[] = "diagnostic_msgs/msg/KeyValue";
  static constexpr auto Fields() {
    return std::make_tuple(Named("key", &KeyValue::key),
                           Named("value", &KeyValue::value));
  }
};

struct DiagnosticStatus {
  static constexpr std::byte kOk{0};
  static constexpr std::byte kWarn{1};
  static constexpr std::byte kError{2};
  static constexpr std::byte kStale{3};

  std::byte level = kOk;
  std::string name;
  std::string message;
  std::string hardware_id;
  std::vector<KeyValue> values;

  bool operator==(const DiagnosticStatus&) const = default;
  static constexpr char kName[] = "diagnostic_msgs/msg/DiagnosticStatus";
  static constexpr auto Fields() {
    return std::make_tuple(Named("level", &DiagnosticStatus::level),
                           Named("name", &DiagnosticStatus::name),
                           Named("message", &DiagnosticStatus::message),
                           Named("hardware_id", &DiagnosticStatus::hardware_id),
                           Named("values", &DiagnosticStatus::values));
  }
};

struct DiagnosticArray {
  Header header;
  std::vector<DiagnosticStatus> status;

  bool operator==(const DiagnosticArray&) const = default;
  static constexpr char kName[] = "diagnostic_msgs/msg/DiagnosticArray";
  static constexpr auto Fields() {
    return std::make_tuple(Named("header", &DiagnosticArray::header),
                           Named("status", &DiagnosticArray::status));
  }
};

}  // namespace treeline::messages

#endif  // COMMON_ROS2_MESSAGES_COMMON_MESSAGES_H_
