#include "server/gateway/form_data.h"

#include <cstddef>
#include <optional>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "common/connect_rpc/connect_error.h"

namespace treeline::gateway {
namespace {

using connect_rpc::InvalidRequest;

constexpr absl::string_view kLineEnd = "\r\n";
constexpr absl::string_view kHeadersEnd = "\r\n\r\n";
constexpr size_t kMaxBoundary = 70;  // RFC 2046
constexpr size_t kMaxHeaders = 4096;
constexpr size_t kMaxName = 100;
constexpr size_t kMaxParts = 32;

// The value of `NAME=VALUE` or `NAME="VALUE"` among the parameters of a header
// behind its first semicolon. Quoted semicolons are no names of ours.
std::optional<std::string> Parameter(absl::string_view header,
                                     absl::string_view name) {
  const std::vector<absl::string_view> parts = absl::StrSplit(header, ';');
  for (size_t i = 1; i < parts.size(); ++i) {
    const std::pair<absl::string_view, absl::string_view> pair =
        absl::StrSplit(parts[i], absl::MaxSplits('=', 1));
    if (!absl::EqualsIgnoreCase(absl::StripAsciiWhitespace(pair.first), name)) {
      continue;
    }
    absl::string_view value = absl::StripAsciiWhitespace(pair.second);
    if (absl::ConsumePrefix(&value, "\"") &&
        !absl::ConsumeSuffix(&value, "\"")) {
      return std::nullopt;
    }
    return std::string(value);
  }
  return std::nullopt;
}

std::optional<std::string> NameOf(absl::string_view headers) {
  for (absl::string_view line : absl::StrSplit(headers, kLineEnd)) {
    const std::pair<absl::string_view, absl::string_view> header =
        absl::StrSplit(line, absl::MaxSplits(':', 1));
    if (absl::EqualsIgnoreCase(header.first, "content-disposition")) {
      return Parameter(header.second, "name");
    }
  }
  return std::nullopt;
}

// Takes one part, up to the delimiter behind it, off the front.
absl::StatusOr<FormPart> TakePart(absl::string_view delimiter,
                                  absl::string_view& rest) {
  const size_t headers = rest.substr(0, kMaxHeaders).find(kHeadersEnd);
  if (headers == absl::string_view::npos) {
    return InvalidRequest("the form has a part without an end of its headers");
  }
  std::optional<std::string> name = NameOf(rest.substr(0, headers));
  if (!name || name->empty() || name->size() > kMaxName) {
    return InvalidRequest("the form has a part without a name");
  }
  rest.remove_prefix(headers + kHeadersEnd.size());
  const size_t end = rest.find(delimiter);
  if (end == absl::string_view::npos) {
    return InvalidRequest(
        absl::StrCat("the form ends within its part '", *name, "'"));
  }
  FormPart part{.name = *std::move(name), .bytes = rest.substr(0, end)};
  rest.remove_prefix(end + delimiter.size());
  return part;
}

}  // namespace

absl::StatusOr<std::vector<FormPart>> ParseFormData(
    absl::string_view content_type, absl::string_view body) {
  const std::optional<std::string> boundary =
      Parameter(content_type, "boundary");
  if (!boundary || boundary->empty() || boundary->size() > kMaxBoundary) {
    return InvalidRequest("multipart/form-data has no boundary");
  }
  const std::string delimiter = absl::StrCat(kLineEnd, "--", *boundary);
  // What comes before the first one does not count.
  if (!absl::ConsumePrefix(&body, absl::string_view(delimiter).substr(2))) {
    const size_t first = body.find(delimiter);
    if (first == absl::string_view::npos) {
      return InvalidRequest("the form does not contain its boundary");
    }
    body.remove_prefix(first + delimiter.size());
  }
  std::vector<FormPart> parts;
  while (!absl::StartsWith(body, "--")) {
    const size_t line = body.find_first_not_of(" \t");
    if (line == absl::string_view::npos ||
        !absl::StartsWith(body.substr(line), kLineEnd)) {
      return InvalidRequest("the form has no line end behind its boundary");
    }
    body.remove_prefix(line + kLineEnd.size());
    if (parts.size() == kMaxParts) {
      return InvalidRequest(
          absl::StrCat("the form has more than ", kMaxParts, " parts"));
    }
    TL_ASSIGN_OR_RETURN(FormPart part, TakePart(delimiter, body));
    parts.push_back(std::move(part));
  }
  return parts;
}

}  // namespace treeline::gateway
