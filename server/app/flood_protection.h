// What cuts off clients that flood the gRPC listeners, as the program has it.
#ifndef SERVER_APP_FLOOD_PROTECTION_H_
#define SERVER_APP_FLOOD_PROTECTION_H_

#include <memory>

#include "common/base/clock.h"
#include "common/flood_guard/flood_guard.h"
#include "common/log/program_log.h"
#include "common/metrics/registry.h"
#include "server/app/server_config.h"

namespace treeline::server_app {

// Null: the settings want none. It writes to the log until it is told to stop;
// log and clock must live so long.
std::shared_ptr<flood_guard::FloodGuard> MakeFloodGuard(
    const ServerConfig& config, logging::ProgramLog& log,
    const base::Clock& clock);

// treeline_grpc_connections_cut_total.
void AddFloodMetrics(metrics::Registry& registry,
                     std::shared_ptr<const flood_guard::FloodGuard> guard);

}  // namespace treeline::server_app

#endif  // SERVER_APP_FLOOD_PROTECTION_H_
