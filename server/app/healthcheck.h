// Asks a server whether it serves, over the wire as a balancer would.
#ifndef SERVER_APP_HEALTHCHECK_H_
#define SERVER_APP_HEALTHCHECK_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::server_app {

struct HealthcheckOptions {
  std::string server = "127.0.0.1:50051";
  // Empty: the server as a whole.
  std::string scene = {};
  double timeout_s = 5;
  // PEM file of the authorities that may vouch for the server; empty: no TLS.
  std::string tls_ca = {};
  // Name in its certificate; empty: the host of `server`.
  std::string tls_name = {};
  // PEM files of our own certificate and key, for mutual TLS; empty: none.
  std::string tls_cert = {};
  std::string tls_key = {};
};

// OK: it answered SERVING. UNAVAILABLE: it is not there, or answered something
// else; NOT_FOUND: it knows no such scene; DEADLINE_EXCEEDED; errors of the
// files.
absl::Status CheckHealth(const HealthcheckOptions& options);

// The messages of grpc.health.v1, by hand: Debian ships no .proto of them, and
// libgrpc++ has one of its own inside, which another copy would clash with.
std::string EncodeHealthRequest(absl::string_view service);
// The enum's number: 1 is SERVING; 0 if the field is not there.
// INVALID_ARGUMENT: not such a message.
absl::StatusOr<int> DecodeHealthResponse(absl::string_view bytes);

}  // namespace treeline::server_app

#endif  // SERVER_APP_HEALTHCHECK_H_
