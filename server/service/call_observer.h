// Who wants to know about calls: logs and metrics.
#ifndef SERVER_SERVICE_CALL_OBSERVER_H_
#define SERVER_SERVICE_CALL_OBSERVER_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "server/core/localizer/localizer.h"

namespace treeline {

// Where the time of a call went, in the order of its stages (ms).
struct CallTimings {
  double queue_ms = 0;
  double decode_ms = 0;
  LocalizeTimings localize;
  double total_ms = 0;
};

// One finished call. Holds nothing of the images.
struct CallRecord {
  const char* rpc = "";
  // "grpc" or "http".
  const char* transport = "";
  // Who called, by token, certificate or address; empty: not admitted.
  std::string client;
  // As the client sent it, not checked.
  std::string traceparent;
  // "ipv4:127.0.0.1:41234", as gRPC names it.
  std::string peer;
  // As the client sent it, not checked: escape it before it is written
  // anywhere. Cut to a length that a valid name may have.
  std::string scene;
  // The version that answered; empty if none did.
  std::string model_version;
  absl::Status status;
  // What went wrong inside where `status` does not tell the client.
  std::string internal_error;
  // With an OK status of Localize.
  double confidence = 0;
  double inlier_ratio = 0;
  std::optional<Outcome> outcome;
  NotLocalizedReason reason = NotLocalizedReason::kNone;
  int inliers = 0;
  int samples = 0;
  CallTimings timings;
};

class CallObserver {
 public:
  virtual ~CallObserver() = default;
  // Called exactly once for each call that reached the service, before its
  // answer is sent, from many threads. Must be quick.
  virtual void OnCall(const CallRecord& record) = 0;
};

}  // namespace treeline

#endif  // SERVER_SERVICE_CALL_OBSERVER_H_
