// Bytes of the Common Data Representation -> values; see cdr_writer.h.
#ifndef COMMON_ROS2_CDR_CDR_READER_H_
#define COMMON_ROS2_CDR_CDR_READER_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "common/ros2/cdr/cdr_writer.h"

namespace treeline::cdr {

// Reads plain CDR of either byte order. The bytes are from outside: every
// length is compared with what is left before anything is allocated. After an
// error everything that is read is 0 or empty, so that only the end of a
// message need be checked. Not thread-safe; `bytes` must outlive it.
class CdrReader {
 public:
  explicit CdrReader(std::span<const uint8_t> bytes);

  template <Primitive T>
  T Read() {
    T value{};
    ReadArray(std::span<T>(&value, 1));
    return value;
  }
  template <Primitive T>
  void ReadArray(std::span<T> values);
  // How many elements follow, each of which takes at least so many bytes.
  size_t ReadCount(size_t min_bytes_each);
  std::string ReadString();

  // INVALID_ARGUMENT says what was wrong, and at which byte.
  const absl::Status& status() const { return status_; }
  // The same, or that there is more than the message: up to three bytes of
  // padding behind it are no error.
  absl::Status Finish() const;

 private:
  size_t left() const { return bytes_.size() - at_; }
  // At a multiple of `size`, and `total` bytes from there. Null after an error.
  const uint8_t* Skip(size_t size, size_t total);
  void Fail(const char* what);

  std::span<const uint8_t> bytes_;
  // From the start of bytes_.
  size_t at_ = 0;
  bool is_swapped_ = false;
  absl::Status status_;
};

template <Primitive T>
void CdrReader::ReadArray(std::span<T> values) {
  if (values.empty()) return;
  const uint8_t* from = Skip(sizeof(T), values.size_bytes());
  if (from == nullptr) {
    std::ranges::fill(values, T{});
    return;
  }
  if constexpr (std::same_as<T, bool>) {
    // Any other value than 0 and 1 is none of a bool's.
    std::ranges::transform(from, from + values.size(), values.begin(),
                           [](uint8_t byte) { return byte != 0; });
    return;
  }
  std::memcpy(values.data(), from, values.size_bytes());
  if (!is_swapped_ || sizeof(T) == 1) return;
  for (T& value : values) {
    auto* raw = reinterpret_cast<uint8_t*>(&value);
    std::reverse(raw, raw + sizeof(T));
  }
}

}  // namespace treeline::cdr

#endif  // COMMON_ROS2_CDR_CDR_READER_H_
