// What treeline-server was told to do.
#ifndef SERVER_APP_COMMAND_LINE_H_
#define SERVER_APP_COMMAND_LINE_H_

#include <optional>

#include "common/config/effective_config.h"
#include "server/app/healthcheck.h"

namespace treeline::server_app {

// Exit codes, as docs/reference/operations.md states them.
inline constexpr int kExitOk = 0;
inline constexpr int kExitFailed = 1;
inline constexpr int kExitUsage = 2;

struct CommandLine {
  enum class Task { kServe, kPrintConfig, kHealthcheck };

  // Set: everything is said, and this is how to exit.
  std::optional<int> exit_code = {};
  Task task = Task::kServe;
  // Of kServe and kPrintConfig.
  config::ConfigSources sources = {};
  // Of kHealthcheck.
  HealthcheckOptions healthcheck = {};
};

// Reads flags, and the variables of ours in `environment`. Prints help and
// version, and on standard error what is wrong.
CommandLine ReadCommandLine(int argc, const char* const* argv,
                            const char* const* environment);

}  // namespace treeline::server_app

#endif  // SERVER_APP_COMMAND_LINE_H_
