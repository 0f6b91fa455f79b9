// Messages as ROS 2's tools define them: text in the format `ros2msg` of MCAP,
// the fields of a message followed by those of all messages that it holds.
#ifndef COMMON_ROS2_MESSAGES_MESSAGE_SCHEMA_H_
#define COMMON_ROS2_MESSAGES_MESSAGE_SCHEMA_H_

#include <string>

#include "common/ros2/messages/message_fields.h"

namespace treeline::messages {

// There for all messages of this folder.
template <Message M>
std::string SchemaText();

}  // namespace treeline::messages

#endif  // COMMON_ROS2_MESSAGES_MESSAGE_SCHEMA_H_
