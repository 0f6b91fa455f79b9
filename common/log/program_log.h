// The log of a program: one line an event, text or JSON.
#ifndef COMMON_LOG_PROGRAM_LOG_H_
#define COMMON_LOG_PROGRAM_LOG_H_

#include <memory>
#include <string>

#include "absl/strings/string_view.h"
#include "common/log/log_line.h"

namespace spdlog {
class logger;
}

namespace treeline::logging {

enum class LogLevel { kDebug, kInfo, kWarn, kError, kOff };

// "debug", "info", "warn", "error" or "off"; anything else is info.
LogLevel LogLevelOf(absl::string_view name);
// "text" or "json"; anything else is text.
LogFormat LogFormatOf(absl::string_view name);

// Writes
//   2026-11-21T11:14:29.887Z info rpc=Localize ...
//   {"ts":"2026-11-21T11:14:29.887Z","level":"info","rpc":"Localize",...}
// Thread-safe.
class ProgramLog {
 public:
  // Writes with `logger`, which gets its pattern here.
  ProgramLog(std::shared_ptr<spdlog::logger> logger, LogFormat format);
  // Takes gRPC's own messages back, if it got them.
  ~ProgramLog();
  ProgramLog(const ProgramLog&) = delete;
  ProgramLog& operator=(const ProgramLog&) = delete;

  LogFormat format() const { return format_; }
  LogLine Event() const { return LogLine(format_); }

  void SetLevel(LogLevel level);
  bool Writes(LogLevel level) const;
  void Write(LogLevel level, const LogLine& event);
  // A sentence.
  void Say(LogLevel level, absl::string_view sentence);

  // From now on gRPC's messages are written here: its errors as such, the rest
  // at debug. Of one log in the process.
  void TakeGrpcMessages();

 private:
  const std::shared_ptr<spdlog::logger> logger_;
  const LogFormat format_;
};

// On standard error, with colours on a terminal.
std::unique_ptr<ProgramLog> LogToStandardError(const std::string& program,
                                               LogFormat format);

}  // namespace treeline::logging

#endif  // COMMON_LOG_PROGRAM_LOG_H_
