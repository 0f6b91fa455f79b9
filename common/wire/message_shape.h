// What an encoded message would become, before anything is built from it.
#ifndef COMMON_WIRE_MESSAGE_SHAPE_H_
#define COMMON_WIRE_MESSAGE_SHAPE_H_

#include <google/protobuf/io/zero_copy_stream.h>
#include <google/protobuf/message.h>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace treeline::wire {

// A request has few fields, of which one is large. An empty text takes 2 bytes
// of a request and 40 of memory; a message of its own, more.
struct MessageLimits {
  // Messages within each other; ours are 6 deep.
  int max_depth = 16;
  // Fields, those of messages within it too, known or not, and elements of
  // packed fields.
  int max_fields = 20000;
};

// Walks the wire format of a message of `type`, and stops where it goes beyond
// `limits`: INVALID_ARGUMENT with reason INVALID_REQUEST, as for bytes that are
// no message. Groups, which proto3 has not, are refused. What passes takes
// little more memory than its bytes once it is parsed. Allocates nothing.
absl::Status CheckMessageShape(google::protobuf::io::ZeroCopyInputStream& bytes,
                               const google::protobuf::Descriptor& type,
                               const MessageLimits& limits = {});

// The same, and then parses. Clears `message` first.
absl::Status ParseMessage(absl::string_view bytes,
                          google::protobuf::Message& message);

}  // namespace treeline::wire

#endif  // COMMON_WIRE_MESSAGE_SHAPE_H_
