// How a server is reached, and what is shown to it.
#ifndef CLIENT_RELOCALIZER_CONNECT_OPTIONS_H_
#define CLIENT_RELOCALIZER_CONNECT_OPTIONS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::relocalizer {

// TLS, and for mutual TLS the client's own certificate. Files are PEM and are
// read again when they change, at most a second later; new connections use the
// new ones.
struct ClientTlsOptions {
  // Certificates that are trusted to sign the server's. Empty: no TLS.
  std::string ca_file = {};
  // The client's certificate chain and its private key: both or neither.
  std::string certificate_file = {};
  std::string key_file = {};
  // The name that the server's certificate must have. Empty: the host that is
  // asked for.
  std::string server_name = {};
};

struct ConnectOptions {
  // "HOST:PORT", any target that gRPC resolves ("dns:///...", in which case
  // calls go round-robin over all its addresses), or several addresses with a
  // port each, separated by commas: "127.0.0.1:50051,127.0.0.1:50052".
  std::string server = {};
  // How often a call is tried while the server answers UNAVAILABLE: 1..5. The
  // waits between tries grow from 50 ms to 1 s, or are what the server asks
  // for, and end with the call's timeout.
  int max_attempts = 4;
  // Largest request and answer (MiB), 1..1024.
  int max_message_mib = 32;
  ClientTlsOptions tls = {};
  // A file that holds the bearer token, read again when it changes; or an
  // environment variable, read once. At most one of them; empty: none.
  std::string token_file = {};
  std::string token_variable = {};
  // Connections of their own rather than those that the process has already:
  // for load that comes from many clients.
  bool own_connections = false;

  // INVALID_ARGUMENT. A token is refused where it would travel in the clear
  // to another machine.
  absl::Status Validate() const;
};

// The target that gRPC understands. A list needs addresses: which of several
// names is meant is what "dns:///" is for.
absl::StatusOr<std::string> GrpcTarget(absl::string_view server);

// Whether every address of `server` is one of this machine: 127.*, [::1],
// localhost, or a socket file.
bool IsOnThisMachine(absl::string_view server);

// Whether it is what URLs have between "http://" and their path: HOST or
// HOST:PORT. None of gRPC's schemes, no user's name, no list.
bool IsUrlHost(absl::string_view address);
// Whether it is one of this machine, too.
bool IsUrlHostOnThisMachine(absl::string_view address);

}  // namespace treeline::relocalizer

#endif  // CLIENT_RELOCALIZER_CONNECT_OPTIONS_H_
