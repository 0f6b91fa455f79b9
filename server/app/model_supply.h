// The scenes that the server answers from, as its configuration says.
#ifndef SERVER_APP_MODEL_SUPPLY_H_
#define SERVER_APP_MODEL_SUPPLY_H_

#include <memory>
#include <stop_token>

#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/log/program_log.h"
#include "server/app/server_config.h"
#include "server/repository/scene_repository.h"

namespace treeline::server_app {

// From a folder, or from a web server by way of a cache. Errors name the flag.
// `stop` ends downloads; `log` and `clock` must outlive the repository.
absl::StatusOr<std::unique_ptr<repository::SceneRepository>> OpenRepository(
    const ServerConfig& config, const std::stop_token& stop,
    logging::ProgramLog& log, const base::Clock& clock);

}  // namespace treeline::server_app

#endif  // SERVER_APP_MODEL_SUPPLY_H_
