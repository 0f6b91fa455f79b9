#include "common/connect_rpc/connect_message.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cstdint>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/connect_rpc/connect_error.h"

namespace treeline::connect_rpc {
namespace {

// A message quotes the JSON where it goes wrong; the rest is of no use.
constexpr size_t kLongestComplaint = 300;

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

absl::Status InvalidBody(absl::string_view message) {
  return base::WithReason(absl::InvalidArgumentError(message),
                          "INVALID_REQUEST");
}

// Each value stands behind one of these. Those within strings count too, so
// that no way to quote, of which protobuf's parser takes more than JSON has,
// hides one.
bool BeginsValue(char c) { return c == '{' || c == '[' || c == ','; }

absl::Status ParseJson(absl::string_view json,
                       google::protobuf::Message& message) {
  if (std::count_if(json.begin(), json.end(), BeginsValue) > kMaxJsonValues) {
    return InvalidBody(
        absl::StrCat("JSON: more than ", kMaxJsonValues, " values"));
  }
  message.Clear();
  const auto parsed = google::protobuf::util::JsonStringToMessage(
      google::protobuf::StringPiece(json.data(), json.size()), &message);
  if (parsed.ok()) return absl::OkStatus();
  const absl::string_view complaint(parsed.message().data(),
                                    parsed.message().size());
  return InvalidBody(absl::StrCat(
      "JSON: ",
      absl::Utf8SafeCHexEscape(complaint.substr(0, kLongestComplaint))));
}

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

std::optional<ConnectFormat> ConnectFormatOf(absl::string_view content_type) {
  const std::string type = absl::AsciiStrToLower(absl::StripAsciiWhitespace(
      content_type.substr(0, content_type.find(';'))));
  for (const ContentTypeRow& row : kContentTypes) {
    if (row.name == type) return row.format;
  }
  return std::nullopt;
}

absl::Status ParseConnectMessage(bool is_json, absl::string_view bytes,
                                 google::protobuf::Message& message) {
  if (is_json) return ParseJson(bytes, message);
  if (message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return absl::OkStatus();
  }
  return InvalidBody(absl::StrCat("the body is not a ", message.GetTypeName(),
                                  " in protobuf's binary format"));
}

absl::StatusOr<std::string> WriteConnectMessage(
    bool is_json, const google::protobuf::Message& message) {
  if (!is_json) return message.SerializeAsString();
  std::string json;
  if (!google::protobuf::util::MessageToJsonString(message, &json).ok()) {
    return absl::InternalError("the answer cannot be written as JSON");
  }
  return json;
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
    return InvalidBody("the body has no message in an envelope");
  }
  if ((body[0] & kCompressed) != 0) {
    return base::WithReason(
        absl::UnimplementedError("messages cannot be compressed"),
        "INVALID_REQUEST");
  }
  if (body[0] != 0) return InvalidBody("the envelope's flags are not known");
  size_t size = 0;
  for (size_t i = 1; i < kEnvelopeBytes; ++i) {
    size = size << 8 | static_cast<uint8_t>(body[i]);
  }
  body.remove_prefix(kEnvelopeBytes);
  if (body.size() != size) {
    return InvalidBody(absl::StrCat("the envelope is of ", size, " bytes, and ",
                                    body.size(), " came"));
  }
  return body;
}

}  // namespace treeline::connect_rpc
