#include "common/ros2/messages/ros1_reader.h"

#include "absl/strings/str_cat.h"

namespace treeline::messages {

size_t Ros1Reader::ReadCount(size_t min_bytes_each) {
  const auto count = static_cast<size_t>(Read<uint32_t>());
  if (count > (bytes_.size() - at_) / std::max<size_t>(min_bytes_each, 1)) {
    Fail("more elements are announced than there are bytes");
    return 0;
  }
  return count;
}

std::string Ros1Reader::ReadString() {
  const size_t count = ReadCount(1);
  const uint8_t* from = Skip(count);
  if (from == nullptr) return "";
  return {reinterpret_cast<const char*>(from), count};
}

absl::Status Ros1Reader::Finish() const {
  if (!status_.ok() || at_ == bytes_.size()) return status_;
  return absl::InvalidArgumentError(absl::StrCat(
      "ROS 1: ", bytes_.size() - at_, " bytes are left behind the message"));
}

const uint8_t* Ros1Reader::Skip(size_t total) {
  if (!status_.ok()) return nullptr;
  if (total > bytes_.size() - at_) {
    Fail("the message is cut off");
    return nullptr;
  }
  const uint8_t* from = bytes_.data() + at_;
  at_ += total;
  return from;
}

void Ros1Reader::Fail(const char* what) {
  if (!status_.ok()) return;
  status_ = absl::InvalidArgumentError(
      absl::StrCat("ROS 1: at byte ", at_, " of ", bytes_.size(), ": ", what));
}

}  // namespace treeline::messages
