// What a transport knows about a call, whichever transport it is.
#ifndef SERVER_SERVICE_CALL_H_
#define SERVER_SERVICE_CALL_H_

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/tracing/trace_context.h"

namespace treeline::service {

// What a client shows to say who it is. Not checked yet.
struct Credentials {
  // Of "authorization: Bearer ..."; empty: none.
  std::string bearer_token = {};
  // Names in the client's certificate, which TLS has verified: its subject
  // alternative names, or else its common name. Empty: none.
  std::vector<std::string> certificate_names = {};
};

// CallInfo::rpc of queries that came by the GeoPose Protocol, which promises
// that nothing of them is kept.
inline constexpr char kGeoPoseRpc[] = "GeoPose";

struct CallInfo {
  // "Localize". A literal.
  const char* rpc = "";
  // "grpc" or "http". A literal.
  const char* transport = "grpc";
  // "ipv4:127.0.0.1:41234", as gRPC names it.
  std::string peer = {};
  Credentials credentials = {};
  // The W3C header of this name as it came, not checked; empty: none.
  std::string traceparent = {};
  // The call's own span, where somebody needed it before the dispatcher.
  std::optional<tracing::TraceContext> span = std::nullopt;
  // Client::id, where the transport has asked Dispatcher::Admit already; then
  // nobody asks again.
  std::optional<std::string> client = std::nullopt;
  // Whether it came in where only operators come in.
  bool admin_listener = false;
  // When the whole request had arrived.
  base::MonotonicTime arrival = {};
  // MonotonicTime::max(): none.
  base::MonotonicTime deadline = base::MonotonicTime::max();
  // Requested when the client cancels or disconnects, or its deadline passes.
  std::stop_token stop = {};
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_CALL_H_
