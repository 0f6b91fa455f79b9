#include "server/app/call_log.h"

#include <utility>

#include "common/base/error_info.h"

namespace treeline::server_app {
namespace {

constexpr auto kWindow = std::chrono::seconds(1);

// Who called for what.
void AddCaller(const service::CallRecord& record, logging::LogLine& event) {
  event.Text("peer", record.peer);
  if (!record.client.empty()) event.Text("client", record.client);
  const auto& trace = record.span.has_value() ? record.span : record.trace;
  if (trace.has_value()) {
    event.Word("trace_id", trace->trace_id);
    event.Word("span_id", trace->span_id);
  }
  if (record.request_bytes > 0) {
    event.Integer("bytes", static_cast<int64_t>(record.request_bytes));
  }
  if (!record.scene.empty()) event.Text("scene", record.scene);
  if (!record.model_version.empty()) {
    event.Text("version", record.model_version);
  }
}

void AddOutcome(const service::CallRecord& record, logging::LogLine& event) {
  if (!record.outcome) return;
  const service::CallTimings& t = record.timings;
  event.Word("outcome", localizer::OutcomeName(*record.outcome))
      .Word("reason", localizer::ReasonName(record.reason))
      .Integer("inliers", record.inliers)
      .Integer("samples", record.samples)
      .Number("decode_ms", t.decode_ms)
      .Number("sample_ms", t.localize.sample_ms)
      .Number("forest_ms", t.localize.forest_ms)
      .Number("pose_ms", t.localize.pose_ms)
      .Number("features_ms", t.localize.features_ms)
      .Number("verify_ms", t.localize.verify_ms);
}

}  // namespace

logging::LogLine EventOf(const service::CallRecord& record,
                         logging::LogFormat format) {
  logging::LogLine event(format);
  event.Word("rpc", record.rpc)
      .Word("status", absl::StatusCodeToString(record.status.code()));
  // Calls by gRPC are the rule.
  if (absl::string_view(record.transport) != "grpc") {
    event.Word("transport", record.transport);
  }
  AddCaller(record, event);
  AddOutcome(record, event);
  event.Number("queue_ms", record.timings.queue_ms)
      .Number("total_ms", record.timings.total_ms);
  if (!record.status.ok()) {
    const std::string reason = base::ErrorInfoOf(record.status).reason;
    if (!reason.empty()) event.Text("error_reason", reason);
    event.Text("message", record.status.message());
  }
  if (!record.internal_error.empty()) {
    event.Text("fault", record.internal_error);
  }
  return event;
}

CallLog::CallLog(logging::ProgramLog& log, const base::Clock& clock)
    : log_(log), clock_(clock), window_start_(clock.Now()) {}

void CallLog::OnCall(const service::CallRecord& record) {
  if (record.status.ok()) {
    if (log_.Writes(logging::LogLevel::kDebug)) {
      log_.Write(logging::LogLevel::kDebug, EventOf(record, log_.format()));
    }
    return;
  }
  const logging::LogLevel level = absl::IsInternal(record.status)
                                      ? logging::LogLevel::kError
                                      : logging::LogLevel::kInfo;
  int64_t suppressed = 0;
  if (!log_.Writes(level) || !Admit(suppressed)) return;
  logging::LogLine event = EventOf(record, log_.format());
  if (suppressed > 0) event.Integer("lines_left_out", suppressed);
  log_.Write(level, event);
}

bool CallLog::Admit(int64_t& suppressed) {
  const base::MonotonicTime now = clock_.Now();
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

}  // namespace treeline::server_app
