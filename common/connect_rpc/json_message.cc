#include "common/connect_rpc/json_message.h"

#include <google/protobuf/util/json_util.h>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/connect_rpc/connect_error.h"

namespace treeline::connect_rpc {
namespace {

// A message quotes the JSON where it goes wrong; the rest is of no use.
constexpr size_t kLongestComplaint = 300;
// What is wrong with bytes, mostly: `base64` of a shell breaks lines, and
// browsers make URLs of files.
constexpr absl::string_view kBytesHint =
    "; bytes are base64 without line breaks and without \"data:...,\" in front";

// Where the string that begins at `quote` ends: the index behind its closing
// quote, which is of the same kind, or the end of `json`.
size_t EndOfString(absl::string_view json, size_t quote) {
  const char ends[] = {json[quote], '\\'};
  size_t i = quote + 1;
  for (;;) {
    i = json.find_first_of(absl::string_view(ends, sizeof(ends)), i);
    if (i == absl::string_view::npos) return json.size();
    if (json[i] == json[quote]) return i + 1;
    i += 2;
  }
}

}  // namespace

absl::Status CheckJsonShape(absl::string_view json, const JsonLimits& limits) {
  int depth = 0;
  int values = 1;
  for (size_t i = 0; i < json.size();) {
    switch (json[i]) {
      // protobuf's parser takes strings in either. To nlohmann's, which does
      // not, what follows a single quote is an error, whatever it is.
      case '"':
      case '\'':
        i = EndOfString(json, i);
        continue;
      case '{':
      case '[':
        ++values;
        if (++depth > limits.max_depth) {
          return InvalidRequest(
              absl::StrCat("JSON: objects and arrays more than ",
                           limits.max_depth, " deep"));
        }
        break;
      case '}':
      case ']':
        --depth;
        break;
      case ',':
        ++values;
        break;
      default:
        break;
    }
    if (values > limits.max_values) {
      return InvalidRequest(
          absl::StrCat("JSON: more than ", limits.max_values, " values"));
    }
    ++i;
  }
  return absl::OkStatus();
}

absl::Status MessageFromJson(absl::string_view json,
                             google::protobuf::Message& message) {
  if (absl::Status shape = CheckJsonShape(json); !shape.ok()) return shape;
  message.Clear();
  const google::protobuf::util::JsonParseOptions options;
  const auto parsed = google::protobuf::util::JsonStringToMessage(
      google::protobuf::StringPiece(json.data(), json.size()), &message,
      options);
  if (parsed.ok()) return absl::OkStatus();
  const absl::string_view complaint(parsed.message().data(),
                                    parsed.message().size());
  return InvalidRequest(absl::StrCat(
      "JSON: ",
      absl::Utf8SafeCHexEscape(complaint.substr(0, kLongestComplaint)),
      absl::StrContains(complaint, "TYPE_BYTES") ? kBytesHint : ""));
}

absl::StatusOr<std::string> JsonFromMessage(
    const google::protobuf::Message& message) {
  std::string json;
  const auto printed =
      google::protobuf::util::MessageToJsonString(message, &json);
  if (!printed.ok()) {
    return absl::InternalError("the answer cannot be written as JSON");
  }
  return json;
}

}  // namespace treeline::connect_rpc
