// The agent's spans: those of its recoveries.
#ifndef NAV_AGENT_APP_RUN_AGENT_TRACING_H_
#define NAV_AGENT_APP_RUN_AGENT_TRACING_H_

#include <memory>

#include "absl/status/statusor.h"
#include "common/log/program_log.h"
#include "common/tracing/tracing.h"
#include "nav_agent/app/relocalization/recovery_trace.h"
#include "nav_agent/app/run/agent_config.h"

namespace treeline::run_app {

// Thread-safe.
class AgentTracing {
 public:
  // Null: nobody wants spans. `log` must outlive it. INVALID_ARGUMENT: the
  // configuration.
  static absl::StatusOr<std::unique_ptr<AgentTracing>> Start(
      const AgentConfig& config, logging::ProgramLog& log);

  relocalization::RecoveryTrace& recovery() { return recovery_; }
  // Ends what lasts, and sends what there is, for a bounded time.
  void Stop();

 private:
  explicit AgentTracing(std::unique_ptr<tracing::Tracing> tracing);

  const std::unique_ptr<tracing::Tracing> tracing_;
  relocalization::RecoveryTrace recovery_;
};

}  // namespace treeline::run_app

#endif  // NAV_AGENT_APP_RUN_AGENT_TRACING_H_
