// Messages <-> plain CDR.
#ifndef COMMON_ROS2_MESSAGES_MESSAGE_CODEC_H_
#define COMMON_ROS2_MESSAGES_MESSAGE_CODEC_H_

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/message_fields.h"

namespace treeline::messages {

// Both are there for all messages of this folder; the encoding stands in front.
template <Message M>
std::vector<uint8_t> Encode(const M& message);
// INVALID_ARGUMENT names the message, what was wrong and at which byte.
// Allocates at most a few times the size of `bytes`.
template <Message M>
absl::StatusOr<M> Decode(std::span<const uint8_t> bytes);

// The same from ROS 1's serialization, whose definitions are these but for a
// sequence number in front of headers. There for those messages that are read
// from bags.
template <Message M>
absl::StatusOr<M> DecodeRos1(std::span<const uint8_t> bytes);

// What a message begins with, whatever follows.
absl::StatusOr<Header> DecodeHeader(std::span<const uint8_t> bytes);
absl::StatusOr<Header> DecodeHeaderRos1(std::span<const uint8_t> bytes);

}  // namespace treeline::messages

#endif  // COMMON_ROS2_MESSAGES_MESSAGE_CODEC_H_
