// Which distributed trace a call belongs to:
// https://www.w3.org/TR/trace-context
#ifndef SERVER_SERVICE_TRACE_CONTEXT_H_
#define SERVER_SERVICE_TRACE_CONTEXT_H_

#include <optional>
#include <string>

#include "absl/strings/string_view.h"

namespace treeline::service {

struct TraceContext {
  // 32 lower-case hexadecimal digits, not all 0.
  std::string trace_id;
  // Of the caller's span ("parent-id"): 16 of them, not all 0.
  std::string span_id;
  // Whether the caller records the trace.
  bool sampled = false;
};

// From the header `traceparent` of version 00:
//   00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01
// nullopt for everything that is not exactly that: what comes out can stand
// anywhere unescaped.
std::optional<TraceContext> ParseTraceparent(absl::string_view header);

}  // namespace treeline::service

#endif  // SERVER_SERVICE_TRACE_CONTEXT_H_
