#include "common/connect_rpc/connect_message.h"

#include <chrono>
#include <cstdint>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/connect_rpc/connect_error.h"
#include "common/connect_rpc/json_message.h"
#include "common/wire/message_shape.h"

namespace treeline::connect_rpc {
namespace {

constexpr std::chrono::milliseconds kPatienceForMemory{2000};

constexpr size_t kEnvelopeBytes = 5;
constexpr char kCompressed = 1;
constexpr char kLast = 2;

struct ContentTypeRow {
  const char* name;
  ConnectFormat format;
};
constexpr ContentTypeRow kContentTypes[] = {
    {"application/proto", {.is_json = false, .is_stream = false}},
    {"application/json", {.is_json = true, .is_stream = false}},
    {"application/connect+proto", {.is_json = false, .is_stream = true}},
    {"application/connect+json", {.is_json = true, .is_stream = true}},
};

std::string Envelope(char flags, absl::string_view bytes) {
  const auto size = static_cast<uint32_t>(bytes.size());
  std::string envelope = {
      flags, static_cast<char>(size >> 24), static_cast<char>(size >> 16),
      static_cast<char>(size >> 8), static_cast<char>(size)};
  envelope.append(bytes.data(), bytes.size());
  return envelope;
}

}  // namespace

const char* ConnectFormat::ContentType() const {
  for (const ContentTypeRow& row : kContentTypes) {
    if (row.format == *this) return row.name;
  }
  return "";
}

std::string MediaType(absl::string_view content_type) {
  return absl::AsciiStrToLower(absl::StripAsciiWhitespace(
      content_type.substr(0, content_type.find(';'))));
}

std::optional<ConnectFormat> ConnectFormatOf(absl::string_view content_type) {
  const std::string type = MediaType(content_type);
  for (const ContentTypeRow& row : kContentTypes) {
    if (row.name == type) return row.format;
  }
  return std::nullopt;
}

absl::StatusOr<base::ByteLease> LeaseForParsing(base::ByteBudget* budget,
                                                bool is_json,
                                                size_t body_bytes) {
  // JSON: what base64 becomes, the message in bytes, and the message.
  const size_t copies = is_json ? 3 : 1;
  base::ByteLease lease(budget);
  if (lease.Resize(copies * body_bytes, kPatienceForMemory)) return lease;
  return base::NoMemoryForRequest();
}

absl::Status ParseConnectMessage(bool is_json, absl::string_view bytes,
                                 google::protobuf::Message& message) {
  return is_json ? MessageFromJson(bytes, message)
                 : wire::ParseMessage(bytes, message);
}

absl::StatusOr<std::string> WriteConnectMessage(
    bool is_json, const google::protobuf::Message& message) {
  if (is_json) return JsonFromMessage(message);
  return message.SerializeAsString();
}

std::string InEnvelope(absl::string_view bytes) { return Envelope(0, bytes); }

std::string EndOfConnectStream(const absl::Status& status) {
  return Envelope(
      kLast, status.ok()
                 ? std::string("{}")
                 : absl::StrCat("{\"error\":", ConnectErrorJson(status), "}"));
}

absl::StatusOr<absl::string_view> OutOfEnvelope(absl::string_view body) {
  if (body.size() < kEnvelopeBytes) {
    return InvalidRequest("the body has no message in an envelope");
  }
  if ((body[0] & kCompressed) != 0) {
    return base::WithReason(
        absl::UnimplementedError("messages cannot be compressed"),
        "INVALID_REQUEST");
  }
  if (body[0] != 0) return InvalidRequest("the envelope's flags are not known");
  size_t size = 0;
  for (size_t i = 1; i < kEnvelopeBytes; ++i) {
    size = size << 8 | static_cast<uint8_t>(body[i]);
  }
  body.remove_prefix(kEnvelopeBytes);
  if (body.size() != size) {
    return InvalidRequest(absl::StrCat("the envelope is of ", size,
                                       " bytes, and ", body.size(), " came"));
  }
  return body;
}

}  // namespace treeline::connect_rpc
