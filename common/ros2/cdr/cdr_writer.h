// Values -> bytes of the Common Data Representation, as DDS and rosbag 2 carry
// them (DDS-XTypes 1.3, 7.4.1: version 1, "plain CDR", little-endian).
#ifndef COMMON_ROS2_CDR_CDR_WRITER_H_
#define COMMON_ROS2_CDR_CDR_WRITER_H_

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"

namespace treeline::cdr {

// What CDR aligns and orders byte by byte. A bool is one byte, 0 or 1.
template <typename T>
concept Primitive = std::integral<T> || std::floating_point<T>;

// A primitive stands at a multiple of its own size, counted from the end of
// the four bytes in front that name the encoding. Not thread-safe.
class CdrWriter {
 public:
  // The encoding: plain CDR, little-endian, no options.
  CdrWriter();

  template <Primitive T>
  void Write(T value) {
    WriteArray(std::span<const T>(&value, 1));
  }
  // The elements alone, as of an array of fixed length. Nothing at all, not
  // even padding, if there are none.
  template <Primitive T>
  void WriteArray(std::span<const T> values) {
    if (values.empty()) return;
    Align(sizeof(T));
    Append(values.data(), values.size_bytes());
  }
  // How many elements follow. Bounded by what a message may hold (2^32 - 1).
  void WriteCount(size_t count) { Write(static_cast<uint32_t>(count)); }
  // With its length in front and a zero byte behind, both of CDR.
  void WriteString(absl::string_view text);

  // Of all so far, the encoding in front included.
  std::vector<uint8_t> Take() && { return std::move(bytes_); }

 private:
  void Align(size_t size);
  void Append(const void* data, size_t size);

  std::vector<uint8_t> bytes_;
};

}  // namespace treeline::cdr

#endif  // COMMON_ROS2_CDR_CDR_WRITER_H_
