// Calls as spans of a trace.
#ifndef SERVER_APP_CALL_SPANS_H_
#define SERVER_APP_CALL_SPANS_H_

#include <functional>
#include <vector>

#include "common/metrics/registry.h"
#include "common/tracing/span.h"
#include "common/tracing/tracer.h"
#include "common/tracing/tracing.h"
#include "server/service/call_observer.h"

namespace treeline::server_app {

// The spans of one call that has a span of its own: the call itself, whose
// attributes are those of OpenTelemetry's semantic conventions for RPCs and
// what the answer says, and one for each stage that it reached. Stages have
// their times, which lie end to end; a query that several methods or scenes
// worked on has their sums. Nothing of pictures, poses, tokens and addresses.
// The ids of the stages come from `tracer`.
std::vector<tracing::Span> SpansOf(const service::CallRecord& record,
                                   tracing::WallTime end,
                                   tracing::Tracer& tracer);

// Hands the spans of calls that are sampled to the tracer; not of callers that
// access control turned away, so that no stranger fills the collector.
class CallSpans final : public service::CallObserver {
 public:
  using WallClock = std::function<tracing::WallTime()>;

  // `tracer` must outlive this.
  CallSpans(tracing::Tracer& tracer, WallClock wall_clock)
      : tracer_(tracer), wall_clock_(std::move(wall_clock)) {}
  void OnCall(const service::CallRecord& record) override;

 private:
  tracing::Tracer& tracer_;
  const WallClock wall_clock_;
};

// treeline_trace_spans_total. `tracing` must outlive the registry's use.
void AddTracingMetrics(metrics::Registry& registry,
                       const tracing::Tracing& tracing);

}  // namespace treeline::server_app

#endif  // SERVER_APP_CALL_SPANS_H_
