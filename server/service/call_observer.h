// Who wants to know about calls: logs and metrics.
#ifndef SERVER_SERVICE_CALL_OBSERVER_H_
#define SERVER_SERVICE_CALL_OBSERVER_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "common/tracing/trace_context.h"
#include "server/core/localizer/localizer.h"

namespace treeline::service {

// Where the time of a call went, in the order of its stages (ms).
struct CallTimings {
  double queue_ms = 0;
  double decode_ms = 0;
  localizer::LocalizeTimings localize;
  double total_ms = 0;
};

// One finished call. Holds nothing of the images.
struct CallRecord {
  const char* rpc = "";
  // "grpc" or "http". A literal.
  const char* transport = "grpc";
  // "ipv4:127.0.0.1:41234", as gRPC names it.
  std::string peer;
  // Who called, as access control knows them (Client::id); empty: nobody
  // known, or turned away before that. Escape it like `scene`.
  std::string client;
  // The caller's span, if it told of one.
  std::optional<tracing::TraceContext> trace;
  // The call's own; nullopt: the server makes none.
  std::optional<tracing::TraceContext> span;
  // Size of the request as it came; 0: not known.
  uint64_t request_bytes = 0;
  // As the client sent it, not checked: escape it before it is written
  // anywhere. Cut to a length that a valid name may have. Where the server
  // found the scene: the one that answered.
  std::string scene;
  // The version that answered; empty if none did. Only with it is `scene` known
  // to be one of ours.
  std::string model_version;
  // Of the model that answered: "rgbd".
  std::string method;
  // Its reason (common/base/error_info.h) is recorded too.
  absl::Status status;
  // Whether it was turned away, because there was too much to do, before any
  // work was done for it: the queue was full, the client's share of it used
  // up, the deadline passed in the queue or was bound to, or the server was
  // stopping.
  bool shed = false;
  // What went wrong inside where `status` does not tell the client.
  std::string internal_error;
  // With an OK status of Localize.
  std::optional<localizer::Outcome> outcome;
  localizer::NotLocalizedReason reason = localizer::NotLocalizedReason::kNone;
  // Where it was localized.
  std::optional<geometry::Rigid3> world_from_camera;
  int inliers = 0;
  int samples = 0;
  // In [0, 1].
  double confidence = 0;
  CallTimings timings;
};

class CallObserver {
 public:
  virtual ~CallObserver() = default;
  // Called exactly once for each call that reached the service, before its
  // answer is sent, from many threads. Must be quick.
  virtual void OnCall(const CallRecord& record) = 0;
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_CALL_OBSERVER_H_
