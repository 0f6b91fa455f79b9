// Bytes of ROS 1's serialization -> values: little-endian, nothing aligned,
// strings without a zero byte (wiki.ros.org, roscpp/Overview/Messages).
#ifndef COMMON_ROS2_MESSAGES_ROS1_READER_H_
#define COMMON_ROS2_MESSAGES_ROS1_READER_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "common/ros2/cdr/cdr_writer.h"

namespace treeline::messages {

// As cdr::CdrReader, which it can stand for. The bytes are from outside: every
// length is compared with what is left before anything is allocated. After an
// error everything that is read is 0 or empty. Not thread-safe; `bytes` must
// outlive it.
class Ros1Reader {
 public:
  explicit Ros1Reader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  template <cdr::Primitive T>
  T Read() {
    T value{};
    ReadArray(std::span<T>(&value, 1));
    return value;
  }
  template <cdr::Primitive T>
  void ReadArray(std::span<T> values) {
    const uint8_t* from = Skip(values.size_bytes());
    if (from == nullptr) {
      std::ranges::fill(values, T{});
    } else if constexpr (std::same_as<T, bool>) {
      std::ranges::transform(from, from + values.size(), values.begin(),
                             [](uint8_t byte) { return byte != 0; });
    } else if (!values.empty()) {
      std::memcpy(values.data(), from, values.size_bytes());
    }
  }
  // How many elements follow, each of which takes at least so many bytes.
  size_t ReadCount(size_t min_bytes_each);
  std::string ReadString();

  // INVALID_ARGUMENT says what was wrong, and at which byte.
  const absl::Status& status() const { return status_; }
  // The same, or that there is more than the message.
  absl::Status Finish() const;

 private:
  // `total` bytes from here. Null after an error.
  const uint8_t* Skip(size_t total);
  void Fail(const char* what);

  std::span<const uint8_t> bytes_;
  size_t at_ = 0;
  absl::Status status_;
};

}  // namespace treeline::messages

#endif  // COMMON_ROS2_MESSAGES_ROS1_READER_H_
