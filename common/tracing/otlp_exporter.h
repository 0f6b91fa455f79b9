// Sends spans to a collector, in the background.
#ifndef COMMON_TRACING_OTLP_EXPORTER_H_
#define COMMON_TRACING_OTLP_EXPORTER_H_

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/tracing/otlp_client.h"
#include "common/tracing/span.h"
#include "common/tracing/tracing_options.h"

namespace treeline::tracing {

struct ExporterLimits {
  // Spans that wait to be sent; what comes beyond is dropped.
  size_t max_queued = 4096;
  // Of one request.
  size_t max_batch = 512;
  // For how long a span waits for others.
  std::chrono::milliseconds delay{1000};
  // Tries of one batch while the collector is away or has too much to do, and
  // the waits between them: doubled each time, and kept until it answers.
  int max_attempts = 5;
  std::chrono::milliseconds first_wait{500};
  std::chrono::milliseconds longest_wait{30'000};
};

// What became of spans since the start.
struct SpanCounts {
  uint64_t sent = 0;
  // Never sent: too many waited, or the program stopped.
  uint64_t dropped = 0;
  // The collector refused them, or could not be reached often enough.
  uint64_t failed = 0;
};

// OTLP over HTTP. Nothing that a collector does or leaves undone is felt by who
// hands in spans, or takes more memory than the limits say. Thread-safe.
class OtlpExporter final : public SpanSink {
 public:
  // Told of the first request that failed after one that did not, and with OK
  // of the first that succeeded again; from the exporter's thread.
  using OnHealth = std::function<void(const absl::Status&)>;

  // INVALID_ARGUMENT: options, which must be enabled().
  static absl::StatusOr<std::unique_ptr<OtlpExporter>> Start(
      const TracingOptions& options, const std::string& version,
      OnHealth on_health, const ExporterLimits& limits = {});
  // Stops without patience.
  ~OtlpExporter() override;

  void Add(std::vector<Span> spans) override;
  // Sends what waits, and returns within `patience` and half a second, also if
  // the collector does not answer. What comes later is dropped.
  void Stop(std::chrono::milliseconds patience);

  SpanCounts counts() const;

 private:
  using Time = std::chrono::steady_clock::time_point;

  OtlpExporter(const TracingOptions& options, std::string version,
               std::unique_ptr<OtlpClient> client, OnHealth on_health,
               const ExporterLimits& limits);

  void Run();
  // Waits for it; empty: the program stops, and nothing is left.
  std::vector<Span> NextBatch();
  void Deliver(const std::vector<Span>& batch);
  // False: the program stops.
  bool Wait(std::chrono::milliseconds duration);
  bool GivesUp() const;
  void NoteHealth(const absl::Status& status);

  const Attributes resource_;
  const std::string version_;
  const ExporterLimits limits_;
  const OnHealth on_health_;
  std::atomic<uint64_t> sent_ = 0;
  std::atomic<uint64_t> dropped_ = 0;
  std::atomic<uint64_t> failed_ = 0;

  mutable absl::Mutex mutex_;
  absl::CondVar changed_;
  std::deque<Span> queue_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  // From when on nothing is worth waiting for.
  Time give_up_ ABSL_GUARDED_BY(mutex_) = Time::max();

  // Of the thread alone, once it runs.
  std::unique_ptr<OtlpClient> client_;
  std::chrono::milliseconds next_wait_;
  bool healthy_ = true;
  std::thread thread_;
};

}  // namespace treeline::tracing

#endif  // COMMON_TRACING_OTLP_EXPORTER_H_
