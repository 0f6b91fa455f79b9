#include "common/ros2/cdr/cdr_reader.h"

#include "absl/strings/str_cat.h"

namespace treeline::cdr {
namespace {

constexpr size_t kEncodingBytes = 4;
constexpr size_t kMaxPadding = 3;

}  // namespace

CdrReader::CdrReader(std::span<const uint8_t> bytes) : bytes_(bytes) {
  if (bytes.size() < kEncodingBytes) {
    at_ = bytes.size();
    Fail("there is no encoding in front");
    return;
  }
  at_ = kEncodingBytes;
  // The first byte, and all of the second but its lowest bit, are 0 for plain
  // CDR of version 1. The other two are options, which mean nothing here.
  if (bytes[0] != 0 || bytes[1] > 1) {
    Fail("the encoding is not plain CDR of version 1");
    return;
  }
  is_swapped_ = bytes[1] == 0;
}

size_t CdrReader::ReadCount(size_t min_bytes_each) {
  const auto count = static_cast<size_t>(Read<uint32_t>());
  if (count > left() / std::max<size_t>(min_bytes_each, 1)) {
    Fail("more elements are announced than there are bytes");
    return 0;
  }
  return count;
}

std::string CdrReader::ReadString() {
  const size_t count = ReadCount(1);
  // Some writers leave out the zero byte of an empty string.
  if (count == 0) return "";
  const uint8_t* from = Skip(1, count);
  if (from == nullptr) return "";
  if (from[count - 1] != 0) {
    Fail("a string has no zero byte at its end");
    return "";
  }
  return {reinterpret_cast<const char*>(from), count - 1};
}

absl::Status CdrReader::Finish() const {
  if (!status_.ok() || left() <= kMaxPadding) return status_;
  return absl::InvalidArgumentError(
      absl::StrCat("CDR: ", left(), " bytes are left behind the message"));
}

const uint8_t* CdrReader::Skip(size_t size, size_t total) {
  const size_t padding = (size - (at_ - kEncodingBytes) % size) % size;
  if (!status_.ok()) return nullptr;
  if (padding > left() || total > left() - padding) {
    Fail("the message is cut off");
    return nullptr;
  }
  const uint8_t* from = bytes_.data() + at_ + padding;
  at_ += padding + total;
  return from;
}

void CdrReader::Fail(const char* what) {
  if (!status_.ok()) return;
  status_ = absl::InvalidArgumentError(
      absl::StrCat("CDR: at byte ", at_, " of ", bytes_.size(), ": ", what));
}

}  // namespace treeline::cdr
