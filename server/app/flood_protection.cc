#include "server/app/flood_protection.h"

#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "common/flood_guard/guarded_sockets.h"

namespace treeline::server_app {

using flood_guard::CutReason;
using flood_guard::FloodGuard;

std::shared_ptr<FloodGuard> MakeFloodGuard(const ServerConfig& config,
                                           logging::ProgramLog& log,
                                           const base::Clock& clock) {
  const std::optional<flood_guard::FloodLimits> limits =
      FloodLimitsOf(config, std::thread::hardware_concurrency());
  if (!limits.has_value()) return nullptr;
  if (!flood_guard::GuardedPort::Works()) {
    log.Say(logging::LogLevel::kWarn,
            "gRPC's connections cannot be watched in this build: floods of "
            "HTTP/2 frames are not cut off");
  }
  return std::make_shared<FloodGuard>(
      *limits, clock, [&log](const std::string& message) {
        log.Say(logging::LogLevel::kWarn, message);
      });
}

void AddFloodMetrics(metrics::Registry& registry,
                     std::shared_ptr<const FloodGuard> guard) {
  registry.AddSource([guard = std::move(guard)](metrics::Exposition& out) {
    out.Family("treeline_grpc_connections_cut_total",
               "Connections that were cut off or not let in, by reason.",
               metrics::MetricType::kCounter);
    for (size_t i = 0; i < flood_guard::kCutReasons; ++i) {
      const auto reason = static_cast<CutReason>(i);
      out.Sample({{"reason", std::string(NameOf(reason))}},
                 static_cast<double>(guard->cuts(reason)));
    }
  });
}

}  // namespace treeline::server_app
