// Messages <-> plain CDR.
#ifndef COMMON_ROS2_MESSAGES_MESSAGE_CODEC_H_
#define COMMON_ROS2_MESSAGES_MESSAGE_CODEC_H_

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "common/ros2/messages/message_fields.h"

namespace treeline::messages {

// Both are there for all messages of this folder; the encoding stands in front.
template <Message M>
std::vector<uint8_t> Encode(const M& message);
// INVALID_ARGUMENT names the message, what was wrong and at which byte.
// Allocates at most a few times the size of `bytes`.
template <Message M>
absl::StatusOr<M> Decode(std::span<const uint8_t> bytes);

}  // namespace treeline::messages

#endif  // COMMON_ROS2_MESSAGES_MESSAGE_CODEC_H_
