// treeline-client's own spans, as the environment asks for them.
#ifndef CLIENT_CLI_CLIENT_TRACING_H_
#define CLIENT_CLI_CLIENT_TRACING_H_

#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/relocalizer/relocalizer.h"
#include "common/tracing/tracing.h"

namespace treeline::client_cli {

// TRACEPARENT is the span that calls belong to, as shells hand it on; where the
// variables of OpenTelemetry name a collector, each call gets a span of its
// own. What is wrong with them is said on standard error, and nothing more.
class ClientTracing {
 public:
  // Of this process' environment.
  ClientTracing();
  // Sends what there is, for a bounded time.
  ~ClientTracing();
  ClientTracing(const ClientTracing&) = delete;
  ClientTracing& operator=(const ClientTracing&) = delete;

 private:
  friend class TracedCall;

  std::optional<tracing::TraceContext> parent_;
  // Null: no spans of its own.
  std::unique_ptr<tracing::Tracing> tracing_;
};

// The span of one call, from its construction on.
class TracedCall {
 public:
  // `tracing` must outlive it.
  explicit TracedCall(ClientTracing& tracing);

  // For the call's options; empty: it belongs to no trace.
  std::string traceparent() const;
  // Not called: there is no span.
  void End(const absl::StatusOr<relocalizer::LocalizeAnswer>& answer);
  // The same of a stream as a whole.
  void EndStream(const absl::Status& status);

 private:
  void Finish(const char* method, const absl::Status& status);

  ClientTracing& tracing_;
  std::optional<tracing::TraceContext> context_;
  tracing::Span span_;
};

}  // namespace treeline::client_cli

#endif  // CLIENT_CLI_CLIENT_TRACING_H_
