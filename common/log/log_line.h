// One line of the log before it has a format.
#ifndef COMMON_LOG_LOG_LINE_H_
#define COMMON_LOG_LOG_LINE_H_

#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"

namespace treeline::logging {

enum class LogFormat { kText, kJson };

// "x" -> "\"x\"", with everything escaped that JSON or a terminal could
// misunderstand; bytes that are not UTF-8 become U+FFFD.
std::string JsonText(absl::string_view text);

// Collects fields in the order of the line:
//   text: rpc=Localize status=OK peer="ipv4:127.0.0.1:4" queue_ms=0.02
//   JSON: "rpc":"Localize","status":"OK","peer":"ipv4:127.0.0.1:4",...
// Keys are literals of a-z and _; nothing in a value can start a line or a
// field of its own.
class LogLine {
 public:
  explicit LogLine(LogFormat format) : format_(format) {}

  // A word of ours, which stands without quotation marks in texts.
  LogLine& Word(absl::string_view key, absl::string_view word);
  // What somebody else chose.
  LogLine& Text(absl::string_view key, absl::string_view text);
  // A sentence. In texts it stands without its key, and for that must come
  // last or alone, and be ours or escaped.
  LogLine& Message(absl::string_view sentence);
  LogLine& Integer(absl::string_view key, int64_t value);
  // With two digits after the point.
  LogLine& Number(absl::string_view key, double value);

  const std::string& fields() const { return fields_; }

 private:
  void Start(absl::string_view key);

  LogFormat format_;
  std::string fields_;
};

}  // namespace treeline::logging

#endif  // COMMON_LOG_LOG_LINE_H_
