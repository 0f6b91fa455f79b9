#include "common/tracing/tracer.h"

#include <cmath>

#include "absl/strings/numbers.h"
#include "absl/strings/str_format.h"
#include "common/base/random.h"

namespace treeline::tracing {
namespace {

// The last 14 digits of a trace's id are random, whoever made it:
// https://www.w3.org/TR/trace-context-2/#random-trace-id-flag
constexpr size_t kRandomDigits = 14;
constexpr double kRandomRange = 0x1.0p56;

}  // namespace

bool IsInShare(const std::string& trace_id, double ratio) {
  uint64_t value = 0;
  if (trace_id.size() < kRandomDigits ||
      !absl::SimpleHexAtoi(trace_id.substr(trace_id.size() - kRandomDigits),
                           &value)) {
    return false;
  }
  return static_cast<double>(value) >= std::round((1 - ratio) * kRandomRange);
}

uint64_t Tracer::NewId() {
  uint64_t id = 0;
  while (id == 0) id = base::Random(seed_, ids_.fetch_add(1)).NextBits();
  return id;
}

TraceContext Tracer::Begin(const std::optional<TraceContext>& parent) {
  TraceContext context;
  if (parent.has_value()) {
    context.trace_id = parent->trace_id;
  } else {
    context.trace_id = absl::StrFormat("%016x%016x", NewId(), NewId());
  }
  context.span_id = absl::StrFormat("%016x", NewId());
  context.sampled = parent.has_value() && sampling_.follows_parent
                        ? parent->sampled
                        : IsInShare(context.trace_id, sampling_.ratio);
  return context;
}

void Tracer::End(std::vector<Span> spans) {
  if (spans.empty() || !spans.front().context.sampled) return;
  sink_.Add(std::move(spans));
}

}  // namespace treeline::tracing
