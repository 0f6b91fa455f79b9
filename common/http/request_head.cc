#include "common/http/request_head.h"

#include <algorithm>
#include <array>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/strip.h"

namespace treeline::http {
namespace {

constexpr absl::string_view kLineEnd = "\r\n";
constexpr size_t kMaxHeaders = 100;
// More digits would not fit into 64 bits.
constexpr size_t kMaxLengthDigits = 18;

// Of these a request has at most one: which of two counts is not the same
// everywhere.
constexpr std::array<absl::string_view, 7> kOnce = {
    "authorization",    "content-encoding", "content-length",
    "content-type",     "expect",           "host",
    "transfer-encoding"};

// RFC 9110, 5.6.2.
bool IsToken(absl::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return absl::ascii_isalnum(c) ||
                  absl::StrContains("!#$%&'*+-.^_`|~", static_cast<char>(c));
         });
}

bool IsVisible(absl::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), absl::ascii_isgraph);
}

// Visible characters, blanks, tabs, and bytes of other alphabets.
bool IsFieldValue(absl::string_view text) {
  return std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return c == '\t' || (c >= 0x20 && c != 0x7f);
  });
}

absl::string_view StripBlanks(absl::string_view text) {
  const size_t begin = text.find_first_not_of(" \t");
  if (begin == absl::string_view::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

// Takes the next line, without its end. False: there is none.
bool TakeLine(absl::string_view& text, absl::string_view& line) {
  const size_t end = text.find(kLineEnd);
  if (end == absl::string_view::npos) return false;
  line = text.substr(0, end);
  text.remove_prefix(end + kLineEnd.size());
  return true;
}

// METHOD SP TARGET SP HTTP/1.x
bool ParseRequestLine(absl::string_view line, RequestHead& head,
                      bool& is_version_1_0) {
  const size_t first = line.find(' ');
  const size_t last = line.rfind(' ');
  if (first == absl::string_view::npos || first == last) return false;
  const absl::string_view method = line.substr(0, first);
  const absl::string_view target = line.substr(first + 1, last - first - 1);
  const absl::string_view version = line.substr(last + 1);
  is_version_1_0 = version == "HTTP/1.0";
  if (!IsToken(method) || !IsVisible(target) ||
      (!is_version_1_0 && version != "HTTP/1.1")) {
    return false;
  }
  head.method = std::string(method);
  head.target = std::string(target);
  return true;
}

bool ParseField(absl::string_view line, RequestHead& head) {
  const size_t colon = line.find(':');
  if (colon == absl::string_view::npos) return false;
  // A line that continues the one before it begins with a blank, which is in no
  // token.
  const absl::string_view name = line.substr(0, colon);
  const absl::string_view value = StripBlanks(line.substr(colon + 1));
  if (!IsToken(name) || !IsFieldValue(value)) return false;
  const bool is_new =
      head.headers.emplace(absl::AsciiStrToLower(name), std::string(value))
          .second;
  return is_new ||
         std::none_of(kOnce.begin(), kOnce.end(), [&](absl::string_view once) {
           return absl::EqualsIgnoreCase(once, name);
         });
}

// What the headers say about the body.
bool FindBody(bool is_version_1_0, RequestHead& head) {
  const auto encoding = head.headers.find("transfer-encoding");
  head.is_chunked = encoding != head.headers.end();
  if (head.is_chunked && (is_version_1_0 || !absl::EqualsIgnoreCase(
                                                encoding->second, "chunked"))) {
    return false;
  }
  const auto length = head.headers.find("content-length");
  if (length == head.headers.end()) return true;
  const std::string& digits = length->second;
  uint64_t bytes = 0;
  // SimpleAtoi would take "+2" and " 2".
  if (head.is_chunked || digits.empty() || digits.size() > kMaxLengthDigits ||
      !std::all_of(digits.begin(), digits.end(), absl::ascii_isdigit) ||
      !absl::SimpleAtoi(digits, &bytes)) {
    return false;
  }
  head.content_length = bytes;
  return true;
}

}  // namespace

HeadScanner::Verdict HeadScanner::Scan(absl::string_view bytes) {
  for (; scanned_ < bytes.size(); ++scanned_) {
    if (bytes[scanned_] == '\0') return Verdict::kMalformed;
    if (bytes[scanned_] != '\n') continue;
    if (scanned_ == line_ || bytes[scanned_ - 1] != '\r') {
      return Verdict::kMalformed;
    }
    const bool is_empty = scanned_ == line_ + 1;
    line_ = scanned_ + 1;
    if (is_empty) {
      ++scanned_;
      return Verdict::kComplete;
    }
  }
  return Verdict::kIncomplete;
}

std::optional<RequestHead> ParseRequestHead(absl::string_view head) {
  RequestHead parsed;
  bool is_version_1_0 = false;
  absl::string_view line;
  if (!TakeLine(head, line) ||
      !ParseRequestLine(line, parsed, is_version_1_0)) {
    return std::nullopt;
  }
  size_t headers = 0;
  while (TakeLine(head, line) && !line.empty()) {
    if (++headers > kMaxHeaders || !ParseField(line, parsed)) {
      return std::nullopt;
    }
  }
  // The empty line is the last.
  if (!line.empty() || !head.empty() || !FindBody(is_version_1_0, parsed)) {
    return std::nullopt;
  }
  return parsed;
}

}  // namespace treeline::http
