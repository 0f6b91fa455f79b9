// Messages in the bodies of the Connect protocol: JSON or binary, alone or in
// the envelopes of a stream. Safe on any bytes.
#ifndef COMMON_CONNECT_RPC_CONNECT_MESSAGE_H_
#define COMMON_CONNECT_RPC_CONNECT_MESSAGE_H_

#include <google/protobuf/message.h>

#include <cstddef>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/base/byte_budget.h"

namespace treeline::connect_rpc {

// How a body carries its messages.
struct ConnectFormat {
  bool is_json = false;
  // Each message in an envelope.
  bool is_stream = false;

  // "application/proto", "application/connect+json" and so on.
  const char* ContentType() const;
  bool operator==(const ConnectFormat&) const = default;
};

// "application/json" of "Application/JSON; charset=utf-8".
std::string MediaType(absl::string_view content_type);

// nullopt: none of the protocol's.
std::optional<ConnectFormat> ConnectFormatOf(absl::string_view content_type);

// Memory for what is made of a body while it is parsed: waits for a while.
// UNAVAILABLE with reason OVERLOADED. nullptr: without a bound.
absl::StatusOr<base::ByteLease> LeaseForParsing(base::ByteBudget* budget,
                                                bool is_json,
                                                size_t body_bytes);

// `bytes` without an envelope. Clears `message` first. INVALID_ARGUMENT with
// reason INVALID_REQUEST: not JSON or not protobuf's binary format, unknown
// fields or values of another type (of JSON, naming the field), or beyond
// JsonLimits or wire::MessageLimits. The latter is found before anything is
// built.
absl::Status ParseConnectMessage(bool is_json, absl::string_view bytes,
                                 google::protobuf::Message& message);

// Without an envelope. JSON as protobuf maps it: lowerCamelCase, 64-bit
// integers as strings, bytes as base64, defaults left out. INTERNAL: it has no
// JSON.
absl::StatusOr<std::string> WriteConnectMessage(
    bool is_json, const google::protobuf::Message& message);

// A flags byte, the length (4 bytes, big-endian), `bytes`.
std::string InEnvelope(absl::string_view bytes);
// The same of the stream's last one, whose bytes are JSON: {} or {"error": }.
std::string EndOfConnectStream(const absl::Status& status);

// The one message that a request of a server's stream consists of.
// INVALID_ARGUMENT: no or another envelope. UNIMPLEMENTED: it is compressed.
absl::StatusOr<absl::string_view> OutOfEnvelope(absl::string_view body);

}  // namespace treeline::connect_rpc

#endif  // COMMON_CONNECT_RPC_CONNECT_MESSAGE_H_
