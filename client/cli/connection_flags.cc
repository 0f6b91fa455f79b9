#include "client/cli/connection_flags.h"

#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/cli/client_command.h"
#include "client/cli/unavailable_hint.h"
#include "client/relocalizer/connect_options.h"
#include "common/base/error_info.h"

namespace treeline::client_cli {

namespace {

constexpr char kTokenVariable[] = "TREELINE_TOKEN";

// "QUEUE_FULL (scene=office)"; empty if the error has no reason.
std::string ReasonText(const absl::Status& status) {
  const base::ErrorInfo info = base::ErrorInfoOf(status);
  if (info.reason.empty()) return "";
  const std::string metadata =
      absl::StrJoin(info.metadata, ", ", absl::PairFormatter("="));
  return absl::StrCat(" [", info.reason, metadata.empty() ? "" : ": ", metadata,
                      "]");
}

}  // namespace

void AddSecurityFlags(CLI::App& app, ConnectionFlags& flags) {
  CLI::Option* ca =
      app.add_option("--tls-ca", flags.tls.ca_file,
                     "Use TLS, and trust servers whose certificate one of "
                     "these signed (PEM)")
          ->type_name("FILE");
  CLI::Option* certificate =
      app.add_option("--tls-cert", flags.tls.certificate_file,
                     "The client's own certificate (PEM), for mutual TLS")
          ->type_name("FILE")
          ->needs(ca);
  CLI::Option* key =
      app.add_option("--tls-key", flags.tls.key_file, "Its private key (PEM)")
          ->type_name("FILE")
          ->needs(certificate);
  certificate->needs(key);
  app.add_option("--token-file", flags.token_file,
                 "File with a bearer token, read again when it changes; "
                 "without: the environment variable TREELINE_TOKEN")
      ->type_name("FILE");
}

void AddServerFlags(CLI::App& app, ConnectionFlags& flags) {
  app.add_option("--server", flags.server,
                 "Where treeline-server listens; several addresses, separated "
                 "by commas, are used in turn")
      ->required()
      ->type_name("HOST:PORT");
  AddSecurityFlags(app, flags);
  app.add_option("--tls-server-name", flags.tls.server_name,
                 "Name that the server's certificate must have; without: the "
                 "host of --server")
      ->type_name("NAME")
      ->needs(app.get_option("--tls-ca"));
  app.add_option("--max-message-mib", flags.max_message_mib,
                 "Largest request and answer, MiB")
      ->capture_default_str()
      ->check(CLI::Range(1, 1024));
}

void AddConnectionFlags(CLI::App& app, ConnectionFlags& flags) {
  AddServerFlags(app, flags);
  app.add_option("--timeout-s", flags.timeout_s,
                 "Seconds that one call may take, retries included")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 86400.0));
}

relocalizer::ConnectOptions ConnectOptionsOf(const ConnectionFlags& flags) {
  const bool variable =
      flags.token_file.empty() && std::getenv(kTokenVariable) != nullptr;
  return {.server = flags.server,
          .max_message_mib = flags.max_message_mib,
          .tls = flags.tls,
          .token_file = flags.token_file,
          .token_variable = variable ? kTokenVariable : ""};
}

relocalizer::CallOptions CallOptionsOf(const ConnectionFlags& flags,
                                       std::stop_token stop) {
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
    hint = "\n" + UnavailableHint(status.message(), flags.server);
  } else if (absl::IsNotFound(status)) {
    hint = absl::StrCat("\n`treeline-client scenes --server ", flags.server,
                        "` lists the scenes.");
  }
  std::fprintf(stderr, "treeline-client: %s: %s%s%s\n",
               absl::StatusCodeToString(status.code()).c_str(),
               std::string(status.message()).c_str(),
               ReasonText(status).c_str(), hint.c_str());
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

}  // namespace treeline::client_cli
