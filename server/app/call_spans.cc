#include "server/app/call_spans.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/base/error_info.h"
#include "server/service/call.h"

namespace treeline::server_app {
namespace {

using tracing::Attributes;
using tracing::Span;
using tracing::WallTime;

std::string Text(absl::string_view text) { return std::string(text); }

WallTime::duration Milliseconds(double ms) {
  return std::chrono::duration_cast<WallTime::duration>(
      std::chrono::duration<double, std::milli>(std::max(0.0, ms)));
}

const char* ServiceOf(absl::string_view rpc) {
  return rpc == "Localize" || rpc == "LocalizeStream"
             ? "treeline.v1.RelocalizationService"
             : "treeline.v1.SceneService";
}

// As OpenTelemetry has it for servers: what the client did wrong is no error
// of the server.
bool IsServersFault(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kDeadlineExceeded:
    case absl::StatusCode::kUnimplemented:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kDataLoss:
      return true;
    default:
      return false;
  }
}

void AddRpc(const service::CallRecord& record, Span& span) {
  if (record.rpc == absl::string_view(service::kGeoPoseRpc)) {
    span.name = "POST /geopose";
    span.attributes.emplace_back("http.request.method", "POST");
    span.attributes.emplace_back("http.route", "/geopose");
    return;
  }
  const char* service = ServiceOf(record.rpc);
  span.name = absl::StrCat(service, "/", record.rpc);
  const bool is_grpc = absl::string_view(record.transport) == "grpc";
  span.attributes.emplace_back("rpc.system", is_grpc ? "grpc" : "connect_rpc");
  span.attributes.emplace_back("rpc.service", service);
  span.attributes.emplace_back("rpc.method", record.rpc);
  if (is_grpc) {
    span.attributes.emplace_back("rpc.grpc.status_code",
                                 static_cast<int64_t>(record.status.code()));
  } else if (!record.status.ok()) {
    // Connect spells it with one L.
    span.attributes.emplace_back(
        "rpc.connect_rpc.error_code",
        absl::IsCancelled(record.status)
            ? "canceled"
            : absl::AsciiStrToLower(
                  absl::StatusCodeToString(record.status.code())));
  }
}

void AddAnswer(const service::CallRecord& record, Attributes& attributes) {
  if (record.request_bytes > 0) {
    attributes.emplace_back("treeline.request_bytes",
                            static_cast<int64_t>(record.request_bytes));
  }
  if (record.shed) attributes.emplace_back("treeline.shed", true);
  // Otherwise it is whatever the client says.
  if (!record.model_version.empty()) {
    attributes.emplace_back("treeline.scene", record.scene);
    attributes.emplace_back("treeline.model_version", record.model_version);
  }
  if (!record.method.empty()) {
    attributes.emplace_back("treeline.method", record.method);
  }
  if (!record.outcome.has_value()) return;
  attributes.emplace_back("treeline.outcome",
                          Text(localizer::OutcomeName(*record.outcome)));
  if (record.reason != localizer::NotLocalizedReason::kNone) {
    attributes.emplace_back("treeline.not_localized_reason",
                            Text(localizer::ReasonName(record.reason)));
  }
  attributes.emplace_back("treeline.confidence", record.confidence);
  attributes.emplace_back("treeline.inliers", int64_t{record.inliers});
  attributes.emplace_back("treeline.samples", int64_t{record.samples});
}

Span CallSpan(const service::CallRecord& record, WallTime end) {
  Span span;
  span.context = *record.span;
  if (record.trace.has_value()) span.parent_span_id = record.trace->span_id;
  span.kind = tracing::SpanKind::kServer;
  span.end = end;
  span.start = end - Milliseconds(record.timings.total_ms);
  AddRpc(record, span);
  AddAnswer(record, span.attributes);
  if (record.status.ok()) return span;
  const std::string reason = base::ErrorInfoOf(record.status).reason;
  span.attributes.emplace_back("error.type", reason);
  span.is_error = IsServersFault(record.status);
  // The message may say what the client made up.
  span.error = reason;
  return span;
}

}  // namespace

std::vector<Span> SpansOf(const service::CallRecord& record, WallTime end,
                          tracing::Tracer& tracer) {
  std::vector<Span> spans{CallSpan(record, end)};
  const auto add = [&](const char* name, const std::string& parent_span_id,
                       WallTime from, WallTime to) {
    Span span;
    span.context = tracer.Begin(record.span);
    span.context.sampled = record.span->sampled;
    span.parent_span_id = parent_span_id;
    span.name = name;
    span.start = from;
    span.end = to;
    spans.push_back(std::move(span));
  };
  WallTime at = spans.front().start;
  const auto stage = [&](const char* name, double ms) {
    const WallTime from = at;
    // Clocks are read one after the other: no stage outlasts its call.
    at = std::min(end, at + Milliseconds(ms));
    add(name, record.span->span_id, from, at);
  };
  const service::CallTimings& t = record.timings;
  if (t.queue_ms > 0) stage("queue", t.queue_ms);
  if (t.decode_ms > 0) stage("decode", t.decode_ms);
  if (!record.outcome.has_value()) return spans;
  stage("sample", t.localize.sample_ms);
  stage("forest", t.localize.forest_ms);
  stage("pose", t.localize.pose_ms);
  // Of the pose: features come first, and verification last.
  const Span pose = spans.back();
  if (t.localize.features_ms > 0) {
    add("features", pose.context.span_id, pose.start,
        std::min(pose.end, pose.start + Milliseconds(t.localize.features_ms)));
  }
  if (t.localize.verify_ms > 0) {
    add("verify", pose.context.span_id,
        std::max(pose.start, pose.end - Milliseconds(t.localize.verify_ms)),
        pose.end);
  }
  return spans;
}

void CallSpans::OnCall(const service::CallRecord& record) {
  if (!record.span.has_value() || !record.span->sampled ||
      absl::IsUnauthenticated(record.status) ||
      absl::IsPermissionDenied(record.status)) {
    return;
  }
  tracer_.End(SpansOf(record, wall_clock_(), tracer_));
}

void AddTracingMetrics(metrics::Registry& registry,
                       const tracing::Tracing& tracing) {
  registry.AddSource([&tracing](metrics::Exposition& out) {
    const tracing::SpanCounts counts = tracing.counts();
    out.Family("treeline_trace_spans_total",
               "Spans of traces by what became of them: sent, dropped before "
               "that, failed at the collector.",
               metrics::MetricType::kCounter);
    out.Sample({{"result", "sent"}}, static_cast<double>(counts.sent));
    out.Sample({{"result", "dropped"}}, static_cast<double>(counts.dropped));
    out.Sample({{"result", "failed"}}, static_cast<double>(counts.failed));
  });
}

}  // namespace treeline::server_app
