// JSON <-> protobuf messages, by protobuf's JSON mapping, within limits.
#ifndef COMMON_CONNECT_RPC_JSON_MESSAGE_H_
#define COMMON_CONNECT_RPC_JSON_MESSAGE_H_

#include <google/protobuf/message.h>

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::connect_rpc {

// What a body may look like before a parser builds something from it: a
// request has few values, of which one is large.
struct JsonLimits {
  // Objects and arrays within each other.
  int max_depth = 32;
  // Values: elements of arrays and fields of objects.
  int max_values = 20000;
};

// INVALID_ARGUMENT with reason INVALID_REQUEST: deeper or with more values than
// `limits`. It does not say that `json` is JSON; it costs one pass.
absl::Status CheckJsonShape(absl::string_view json,
                            const JsonLimits& limits = {});

// Clears `message` first. The same error: no JSON, over the limits, and, naming
// the field, unknown fields and values of another type.
absl::Status MessageFromJson(absl::string_view json,
                             google::protobuf::Message& message);

// lowerCamelCase names; fields with default values are left out, 64-bit
// integers are strings, bytes are base64.
absl::StatusOr<std::string> JsonFromMessage(
    const google::protobuf::Message& message);

}  // namespace treeline::connect_rpc

#endif  // COMMON_CONNECT_RPC_JSON_MESSAGE_H_
