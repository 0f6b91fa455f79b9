// Which spans there are: their ids, and whether they are recorded.
#ifndef COMMON_TRACING_TRACER_H_
#define COMMON_TRACING_TRACER_H_

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/tracing/span.h"
#include "common/tracing/trace_context.h"

namespace treeline::tracing {

// Which traces are recorded.
struct Sampling {
  // Of the traces that begin here, the share that is, in [0, 1]. A trace's id
  // decides, so that every program decides the same.
  double ratio = 1;
  // Whether a trace that a caller began is recorded if and only if the caller
  // says so; otherwise its id decides, too.
  bool follows_parent = true;
};

// Thread-safe.
class Tracer {
 public:
  // `seed` must differ from process to process: ids are made of it. `sink` must
  // outlive the tracer.
  Tracer(SpanSink& sink, Sampling sampling, uint64_t seed)
      : sink_(sink), sampling_(sampling), seed_(seed) {}

  // Of a new span: in its parent's trace, or in a new one.
  TraceContext Begin(const std::optional<TraceContext>& parent);
  // What is not sampled is dropped. Never waits.
  void End(std::vector<Span> spans);

 private:
  uint64_t NewId();

  SpanSink& sink_;
  const Sampling sampling_;
  const uint64_t seed_;
  std::atomic<uint64_t> ids_ = 0;
};

// Whether a share of all traces includes this one.
bool IsInShare(const std::string& trace_id, double ratio);

}  // namespace treeline::tracing

#endif  // COMMON_TRACING_TRACER_H_
