#include "common/tracing/tracing.h"

#include <random>
#include <utility>

#include "common/base/status_macros.h"

namespace treeline::tracing {

absl::StatusOr<std::unique_ptr<Tracing>> Tracing::Start(
    const TracingOptions& options, const std::string& version, uint64_t seed,
    OtlpExporter::OnHealth on_health) {
  TL_ASSIGN_OR_RETURN(
      std::unique_ptr<OtlpExporter> exporter,
      OtlpExporter::Start(options, version, std::move(on_health)));
  return std::unique_ptr<Tracing>(
      new Tracing(std::move(exporter), options.sampling, seed));
}

uint64_t SeedOfProcess() {
  std::random_device source;
  return uint64_t{source()} << 32 | source();
}

}  // namespace treeline::tracing
