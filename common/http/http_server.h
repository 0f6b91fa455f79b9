// A listener for HTTP/1.1: connections, threads, limits. The sockets are ours,
// for httplib's have no limit on the time of a whole request, none on the
// number of connections, and no way to see that a client has gone.
#ifndef COMMON_HTTP_HTTP_SERVER_H_
#define COMMON_HTTP_HTTP_SERVER_H_

#include <openssl/ssl.h>

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/byte_budget.h"
#include "common/base/clock.h"
#include "common/http/http_message.h"
#include "common/http/stream_limits.h"

namespace treeline::http {

// How connections are encrypted.
struct ServerTls {
  // Sets up the context that all connections share: certificates, client
  // certificates, versions. The parameter of httplib::SSLServer's constructor,
  // so that what serves one serves the other. False: it failed.
  std::function<bool(SSL_CTX&)> configure;
  // Names in the certificate that a client has shown and TLS has verified;
  // empty: CallInfo has none.
  std::function<std::vector<std::string>(SSL*)> client_names = {};
};

struct HttpServerOptions {
  // "HOST:PORT" with an IPv4 address, a bracketed IPv6 address or a name; port
  // 0 takes any that is free.
  std::string listen = "127.0.0.1:8080";
  // Whether `listen` may be reached from other machines although nothing is
  // encrypted. Not asked with TLS.
  bool insecure_any_address = false;
  // Largest body of a request, as sent and after decompression, 1..1024.
  int max_body_mib = 32;
  // Connections at a time, each with a thread, 1..10000. At the limit the one
  // that has been idle longest makes room; if none is idle, the one whose
  // request arrives slowest, below StreamLimits::min_body_bytes_per_s; if there
  // is none, one that sends or takes something, of the address that has most of
  // them, if that has more than the new one's would have. If all are busy, the
  // new one gets 503.
  int max_connections = 256;
  // Of one address, or of one IPv6 network of 64 bits, in the same way; 0: no
  // limit of its own.
  int max_connections_per_client = 0;
  // Connections beyond max_connections, for HttpHandler::IsProbe alone,
  // 0..1000. The one that has been there longest without an answer makes room.
  int max_probe_connections = 0;
  // What the bodies of all requests are held by, while they arrive too;
  // nullptr: without a bound. Must outlive the server.
  base::ByteBudget* budget = nullptr;
  // What large answers are held by until their clients have taken them.
  base::ByteBudget* answers = nullptr;
  // For how long a connection may wait for its next request.
  std::chrono::milliseconds idle_timeout{60000};
  StreamLimits stream = {};
  // nullopt: plain.
  std::optional<ServerTls> tls = std::nullopt;

  absl::Status Validate() const;
};

// Serves from construction to Stop().
class HttpServer {
 public:
  // INVALID_ARGUMENT: options. UNAVAILABLE: the address cannot be bound, with
  // the system's reason. `handler` and `clock` must outlive the server.
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(
      const HttpServerOptions& options, HttpHandler& handler,
      const base::Clock& clock);
  // Stops without waiting for requests in flight.
  ~HttpServer();

  // HOST:PORT with the port that was bound.
  const std::string& address() const;

  // Closes the listener and idle connections, waits up to `grace` for the
  // requests in flight, then closes their connections, which handlers see as
  // clients that have gone, and returns when the last has ended.
  void Stop(std::chrono::milliseconds grace);

 private:
  class Impl;
  explicit HttpServer(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_HTTP_SERVER_H_
