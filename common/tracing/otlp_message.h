// Spans as a message of OTLP, 1.x:
// https://github.com/open-telemetry/opentelemetry-proto
#ifndef COMMON_TRACING_OTLP_MESSAGE_H_
#define COMMON_TRACING_OTLP_MESSAGE_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/tracing/span.h"

namespace treeline::tracing {

// An ExportTraceServiceRequest in binary Protocol Buffers: one resource, one
// scope ("treeline", with `version`), all spans. Text that is not UTF-8, which
// collectors would refuse the whole message for, has '?' for each byte that is
// not ASCII, and is cut at 1 KiB.
std::string OtlpMessage(const Attributes& resource, absl::string_view version,
                        const std::vector<Span>& spans);

}  // namespace treeline::tracing

#endif  // COMMON_TRACING_OTLP_MESSAGE_H_
