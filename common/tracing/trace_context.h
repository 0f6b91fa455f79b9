// Which distributed trace something belongs to:
// https://www.w3.org/TR/trace-context
#ifndef COMMON_TRACING_TRACE_CONTEXT_H_
#define COMMON_TRACING_TRACE_CONTEXT_H_

#include <optional>
#include <string>

#include "absl/strings/string_view.h"

namespace treeline::tracing {

// A span's place in a trace.
struct TraceContext {
  // 32 lower-case hexadecimal digits, not all 0.
  std::string trace_id;
  // Of the span ("parent-id" where a caller tells of it): 16 of them, not all
  // 0.
  std::string span_id;
  // Whether the trace is recorded.
  bool sampled = false;
};

// From the header `traceparent` of version 00:
//   00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01
// nullopt for everything that is not exactly that: what comes out can stand
// anywhere unescaped.
std::optional<TraceContext> ParseTraceparent(absl::string_view header);

// The header that makes `context` the caller's.
std::string Traceparent(const TraceContext& context);

}  // namespace treeline::tracing

#endif  // COMMON_TRACING_TRACE_CONTEXT_H_
