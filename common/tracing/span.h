// One piece of work in a trace, as OpenTelemetry has it:
// https://opentelemetry.io/docs/specs/otel/trace/api/#span
#ifndef COMMON_TRACING_SPAN_H_
#define COMMON_TRACING_SPAN_H_

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/tracing/trace_context.h"

namespace treeline::tracing {

using AttributeValue = std::variant<bool, int64_t, double, std::string>;
// By name, each name once.
using Attributes = std::vector<std::pair<std::string, AttributeValue>>;

// With the numbers of OTLP.
enum class SpanKind : uint8_t { kInternal = 1, kServer = 2, kClient = 3 };

using WallTime = std::chrono::system_clock::time_point;

struct Span {
  TraceContext context = {};
  // 16 hexadecimal digits; empty: the trace begins with it.
  std::string parent_span_id = {};
  std::string name = {};
  SpanKind kind = SpanKind::kInternal;
  WallTime start = {};
  WallTime end = {};
  Attributes attributes = {};
  bool is_error = false;
  // What went wrong, if something did.
  std::string error = {};
};

// Where finished spans go.
class SpanSink {
 public:
  virtual ~SpanSink() = default;
  // Takes spans of one trace, or drops them all. Thread-safe; never waits.
  virtual void Add(std::vector<Span> spans) = 0;
};

}  // namespace treeline::tracing

#endif  // COMMON_TRACING_SPAN_H_
