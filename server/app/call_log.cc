#include "server/app/call_log.h"

#include <spdlog/logger.h>

#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"

namespace treeline {
namespace {

constexpr auto kWindow = std::chrono::seconds(1);

// A value that a client chose, in quotation marks, on one line.
std::string Quoted(absl::string_view value) {
  // Apostrophes do no harm there.
  return absl::StrCat(
      "\"", absl::StrReplaceAll(absl::CHexEscape(value), {{"\\'", "'"}}), "\"");
}

}  // namespace

std::string FormatCall(const CallRecord& record) {
  std::string line =
      absl::StrCat("rpc=", record.rpc,
                   " status=", absl::StatusCodeToString(record.status.code()),
                   " peer=", Quoted(record.peer));
  if (!record.scene.empty()) {
    absl::StrAppend(&line, " scene=", Quoted(record.scene));
  }
  if (!record.model_version.empty()) {
    absl::StrAppend(&line, " version=", Quoted(record.model_version));
  }
  if (record.outcome) {
    const CallTimings& t = record.timings;
    absl::StrAppend(&line, " outcome=", OutcomeName(*record.outcome),
                    " reason=", ReasonName(record.reason),
                    " inliers=", record.inliers, " samples=", record.samples);
    absl::StrAppendFormat(&line,
                          " decode_ms=%.2f sample_ms=%.2f forest_ms=%.2f "
                          "pose_ms=%.2f",
                          t.decode_ms, t.localize.sample_ms,
                          t.localize.forest_ms, t.localize.pose_ms);
  }
  absl::StrAppendFormat(&line, " queue_ms=%.2f total_ms=%.2f",
                        record.timings.queue_ms, record.timings.total_ms);
  if (!record.status.ok()) {
    absl::StrAppend(&line, " message=", Quoted(record.status.message()));
  }
  if (!record.internal_error.empty()) {
    absl::StrAppend(&line, " fault=", Quoted(record.internal_error));
  }
  return line;
}

CallLog::CallLog(std::shared_ptr<spdlog::logger> logger, const Clock& clock)
    : logger_(std::move(logger)), clock_(clock), window_start_(clock.Now()) {}

void CallLog::OnCall(const CallRecord& record) {
  if (record.status.ok()) {
    if (logger_->should_log(spdlog::level::debug)) {
      logger_->debug(FormatCall(record));
    }
    return;
  }
  const auto level = absl::IsInternal(record.status) ? spdlog::level::err
                                                     : spdlog::level::info;
  int64_t suppressed = 0;
  if (!logger_->should_log(level) || !Admit(suppressed)) return;
  std::string line = FormatCall(record);
  if (suppressed > 0) absl::StrAppend(&line, " lines_left_out=", suppressed);
  logger_->log(level, line);
}

bool CallLog::Admit(int64_t& suppressed) {
  const MonotonicTime now = clock_.Now();
  absl::MutexLock lock(&mutex_);
  if (now - window_start_ >= kWindow) {
    window_start_ = now;
    lines_in_window_ = 0;
  }
  if (lines_in_window_ >= kMaxLines) {
    ++suppressed_;
    return false;
  }
  ++lines_in_window_;
  suppressed = std::exchange(suppressed_, 0);
  return true;
}

}  // namespace treeline
