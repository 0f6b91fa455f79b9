// RelocalizationService.Localize, without gRPC around it.
#ifndef SERVER_SERVICE_LOCALIZE_RPC_H_
#define SERVER_SERVICE_LOCALIZE_RPC_H_

#include <stop_token>

#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/image/decode.h"
#include "server/repository/scene_repository.h"
#include "server/service/call_observer.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline {

// What surrounds one call.
struct CallContext {
  // When the whole request had arrived.
  MonotonicTime arrival;
  // MonotonicTime::max(): none.
  MonotonicTime deadline = MonotonicTime::max();
  // Requested when the client cancels, disconnects, or its deadline passes.
  std::stop_token stop;
};

class LocalizeRpc {
 public:
  LocalizeRpc(SceneRepository& repository, const DecodeLimits& limits,
              const Clock& clock)
      : repository_(repository), limits_(limits), clock_(clock) {}

  // Answers a request that has just left the queue, on the calling thread.
  // A call whose deadline has passed or that was cancelled costs nothing: it
  // is turned away before anything is decoded. Fills `record` but for rpc,
  // peer and status. Errors as in relocalization.proto.
  absl::StatusOr<v1::LocalizeResponse> Handle(
      const v1::LocalizeRequest& request, const CallContext& context,
      CallRecord& record) const;

 private:
  SceneRepository& repository_;
  const DecodeLimits limits_;
  const Clock& clock_;
};

}  // namespace treeline

#endif  // SERVER_SERVICE_LOCALIZE_RPC_H_
