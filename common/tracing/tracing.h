// A program's spans, from their making to the collector.
#ifndef COMMON_TRACING_TRACING_H_
#define COMMON_TRACING_TRACING_H_

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "common/tracing/otlp_exporter.h"
#include "common/tracing/tracer.h"
#include "common/tracing/tracing_options.h"

namespace treeline::tracing {

// Thread-safe.
class Tracing {
 public:
  // How long a program that ends waits for its last spans to go out.
  static constexpr std::chrono::milliseconds kPatience{2000};

  // `seed`: see Tracer. INVALID_ARGUMENT: options, which must be enabled().
  static absl::StatusOr<std::unique_ptr<Tracing>> Start(
      const TracingOptions& options, const std::string& version, uint64_t seed,
      OtlpExporter::OnHealth on_health);

  Tracer& tracer() { return tracer_; }
  SpanCounts counts() const { return exporter_->counts(); }
  void Stop(std::chrono::milliseconds patience) { exporter_->Stop(patience); }

 private:
  Tracing(std::unique_ptr<OtlpExporter> exporter, const Sampling& sampling,
          uint64_t seed)
      : exporter_(std::move(exporter)), tracer_(*exporter_, sampling, seed) {}

  const std::unique_ptr<OtlpExporter> exporter_;
  Tracer tracer_;
};

// Another in each process.
uint64_t SeedOfProcess();

}  // namespace treeline::tracing

#endif  // COMMON_TRACING_TRACING_H_
