// What every subcommand needs to reach a server.
#ifndef CLIENT_CLI_CONNECTION_FLAGS_H_
#define CLIENT_CLI_CONNECTION_FLAGS_H_

#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "client/relocalizer/connect_options.h"
#include "client/relocalizer/relocalizer.h"

namespace CLI {
class App;
}

namespace treeline::client_cli {

struct ConnectionFlags {
  std::string server;
  relocalizer::ClientTlsOptions tls;
  std::string token_file;
  int max_message_mib = 32;
  double timeout_s = 10;
};

// --tls-... and --token-file.
void AddSecurityFlags(CLI::App& app, ConnectionFlags& flags);
// These, --server and --max-message-mib.
void AddServerFlags(CLI::App& app, ConnectionFlags& flags);
// These, and --timeout-s.
void AddConnectionFlags(CLI::App& app, ConnectionFlags& flags);

// Without a file, the token is what the environment variable TREELINE_TOKEN
// holds, if there is one.
relocalizer::ConnectOptions ConnectOptionsOf(const ConnectionFlags& flags);

relocalizer::CallOptions CallOptionsOf(const ConnectionFlags& flags,
                                       std::stop_token stop);

// Says on standard error what went wrong and, where it helps, what to do.
// Returns the exit code for it.
int ReportFailure(const absl::Status& status, const ConnectionFlags& flags,
                  const std::stop_token& stop);

// The same for what failed before a server was asked.
int ReportLocalFailure(const absl::Status& status);

// Whether everything written to standard output got there (a full disk, a
// closed pipe); says so if not.
bool FlushOutput();

}  // namespace treeline::client_cli

#endif  // CLIENT_CLI_CONNECTION_FLAGS_H_
