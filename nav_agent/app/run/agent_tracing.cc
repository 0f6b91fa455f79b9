#include "nav_agent/app/run/agent_tracing.h"

#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "common/config/setting.h"

namespace treeline::run_app {

AgentTracing::AgentTracing(std::unique_ptr<tracing::Tracing> tracing)
    : tracing_(std::move(tracing)), recovery_(tracing_->tracer(), [] {
        return std::chrono::system_clock::now();
      }) {}

absl::StatusOr<std::unique_ptr<AgentTracing>> AgentTracing::Start(
    const AgentConfig& config, logging::ProgramLog& log) {
  TL_ASSIGN_OR_RETURN(const tracing::TracingOptions options, config.Tracing());
  if (!options.enabled()) return std::unique_ptr<AgentTracing>();
  log.Say(
      logging::LogLevel::kInfo,
      absl::StrCat("traces go to ", config::RedactAddress(options.endpoint)));
  TL_ASSIGN_OR_RETURN(std::unique_ptr<tracing::Tracing> tracing,
                      tracing::Tracing::Start(
                          options, base::Version(), tracing::SeedOfProcess(),
                          [&log](const absl::Status& health) {
                            log.Say(health.ok() ? logging::LogLevel::kInfo
                                                : logging::LogLevel::kWarn,
                                    health.ok()
                                        ? "traces are sent again"
                                        : absl::StrCat("traces are not sent: ",
                                                       health.message()));
                          }));
  return std::unique_ptr<AgentTracing>(new AgentTracing(std::move(tracing)));
}

void AgentTracing::Stop() {
  recovery_.Stop();
  tracing_->Stop(tracing::Tracing::kPatience);
}

}  // namespace treeline::run_app
