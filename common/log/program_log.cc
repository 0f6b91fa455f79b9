#include "common/log/program_log.h"

#include <grpc/support/log.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/stdout_color_sinks.h>

#include <atomic>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::logging {
namespace {

constexpr char kTextPattern[] = "%Y-%m-%dT%H:%M:%S.%eZ %^%l%$ %v";
constexpr char kJsonPattern[] =
    "{\"ts\":\"%Y-%m-%dT%H:%M:%S.%eZ\",\"level\":\"%l\",%v}";

spdlog::level::level_enum ToSpdlog(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarn:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
    case LogLevel::kOff:
      break;
  }
  return spdlog::level::off;
}

// gRPC's hook takes a bare function: there is no other way to it.
std::atomic<ProgramLog*>& GrpcLog() {
  static std::atomic<ProgramLog*> log = nullptr;
  return log;
}

void LogFromGrpc(gpr_log_func_args* args) {
  ProgramLog* log = GrpcLog().load();
  if (log == nullptr) return;
  log->Say(args->severity == GPR_LOG_SEVERITY_ERROR ? LogLevel::kError
                                                    : LogLevel::kDebug,
           absl::StrCat("grpc: ", args->message));
}

}  // namespace

LogLevel LogLevelOf(absl::string_view name) {
  if (name == "debug") return LogLevel::kDebug;
  if (name == "warn") return LogLevel::kWarn;
  if (name == "error") return LogLevel::kError;
  if (name == "off") return LogLevel::kOff;
  return LogLevel::kInfo;
}

LogFormat LogFormatOf(absl::string_view name) {
  return name == "json" ? LogFormat::kJson : LogFormat::kText;
}

ProgramLog::ProgramLog(std::shared_ptr<spdlog::logger> logger, LogFormat format)
    : logger_(std::move(logger)), format_(format) {
  logger_->set_pattern(format == LogFormat::kJson ? kJsonPattern : kTextPattern,
                       spdlog::pattern_time_type::utc);
}

ProgramLog::~ProgramLog() {
  ProgramLog* self = this;
  GrpcLog().compare_exchange_strong(self, nullptr);
}

void ProgramLog::SetLevel(LogLevel level) {
  logger_->set_level(ToSpdlog(level));
}

bool ProgramLog::Writes(LogLevel level) const {
  return logger_->should_log(ToSpdlog(level));
}

void ProgramLog::Write(LogLevel level, const LogLine& event) {
  logger_->log(ToSpdlog(level), event.fields());
}

void ProgramLog::Say(LogLevel level, absl::string_view sentence) {
  if (Writes(level)) Write(level, Event().Message(sentence));
}

void ProgramLog::TakeGrpcMessages() {
  GrpcLog().store(this);
  gpr_set_log_function(&LogFromGrpc);
}

std::unique_ptr<ProgramLog> LogToStandardError(const std::string& program,
                                               LogFormat format) {
  return std::make_unique<ProgramLog>(
      std::make_shared<spdlog::logger>(
          program, std::make_shared<spdlog::sinks::stderr_color_sink_mt>()),
      format);
}

}  // namespace treeline::logging
