#include "client/cli/connection_flags.h"

#include <cstdio>
#include <string>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "client/cli/commands.h"

namespace treeline {

void AddConnectionFlags(CLI::App& app, ConnectionFlags& flags) {
  app.add_option("--server", flags.server, "Where treeline-server listens")
      ->required()
      ->type_name("HOST:PORT");
  app.add_option("--timeout-s", flags.timeout_s,
                 "Seconds that one call may take, retries included")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 86400.0));
}

CallOptions CallOptionsOf(const ConnectionFlags& flags, std::stop_token stop) {
  return {.timeout = std::chrono::milliseconds(
              static_cast<int64_t>(flags.timeout_s * 1e3)),
          .stop = std::move(stop)};
}

int ReportFailure(const absl::Status& status, const ConnectionFlags& flags,
                  const std::stop_token& stop) {
  if (stop.stop_requested()) {
    std::fprintf(stderr, "treeline-client: interrupted\n");
    return kExitInterrupted;
  }
  std::string hint;
  if (absl::IsUnavailable(status)) {
    hint = absl::StrCat("\nIs treeline-server running at ", flags.server,
                        ", and not overloaded?");
  } else if (absl::IsNotFound(status)) {
    hint = absl::StrCat("\n`treeline-client scenes --server ", flags.server,
                        "` lists the scenes.");
  }
  std::fprintf(stderr, "treeline-client: %s: %s%s\n",
               absl::StatusCodeToString(status.code()).c_str(),
               std::string(status.message()).c_str(), hint.c_str());
  return kExitFailed;
}

int ReportLocalFailure(const absl::Status& status) {
  std::fprintf(stderr, "treeline-client: %s\n",
               std::string(status.message()).c_str());
  return kExitFailed;
}

bool FlushOutput() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return true;
  std::fprintf(stderr, "treeline-client: writing standard output failed\n");
  return false;
}

}  // namespace treeline
