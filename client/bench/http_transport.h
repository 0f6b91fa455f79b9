// Calls over HTTP/1.1, with libcurl.
#ifndef CLIENT_BENCH_HTTP_TRANSPORT_H_
#define CLIENT_BENCH_HTTP_TRANSPORT_H_

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "client/bench/http_target.h"
#include "client/bench/transport.h"
#include "client/bench/workload.h"
#include "client/relocalizer/connect_options.h"

namespace treeline::bench {

// All bodies are made here, before anything is sent. `options.server`: one
// address of the HTTP listener or several, separated by commas, used in turn;
// over TLS if there is a CA. Attempts and message sizes of the options are not
// looked at. At most `max_connections` calls are on the wire at a time, since
// HTTP/1.1 has one a connection; others wait here, and that counts as latency.
// INVALID_ARGUMENT: the options, or what the target cannot say; otherwise what
// is wrong with a token's file.
absl::StatusOr<std::unique_ptr<Transport>> MakeHttpTransport(
    Target target, const relocalizer::ConnectOptions& options,
    int max_connections, const std::vector<WorkItem>& items);

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_HTTP_TRANSPORT_H_
