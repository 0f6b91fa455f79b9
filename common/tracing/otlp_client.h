// One request to a collector at a time.
#ifndef COMMON_TRACING_OTLP_CLIENT_H_
#define COMMON_TRACING_OTLP_CLIENT_H_

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/tracing/tracing_options.h"

namespace treeline::tracing {

struct PostResult {
  // OK: the collector has taken it. UNAVAILABLE: it may take it later.
  // Everything else: it never will.
  absl::Status status;
  // How long it wants to be left alone.
  std::optional<std::chrono::milliseconds> retry_after = std::nullopt;
};

// Posts to one address, over a connection that is kept. Redirections are not
// followed, and of an answer nothing but its status is looked at. For one
// thread at a time.
class OtlpClient {
 public:
  // INVALID_ARGUMENT, INTERNAL.
  static absl::StatusOr<std::unique_ptr<OtlpClient>> Open(
      const TracingOptions& options);
  ~OtlpClient();

  // `gives_up` is asked ten times a second while it lasts; then the result is
  // CANCELLED. Otherwise it ends with the options' timeout at the latest.
  PostResult Post(const std::string& message,
                  const std::function<bool()>& gives_up);

 private:
  struct Handles;
  explicit OtlpClient(std::unique_ptr<Handles> handles);

  std::unique_ptr<Handles> handles_;
};

}  // namespace treeline::tracing

#endif  // COMMON_TRACING_OTLP_CLIENT_H_
