// RelocalizationService.Localize on a worker: from the request to the answer.
#ifndef SERVER_SERVICE_LOCALIZE_RPC_H_
#define SERVER_SERVICE_LOCALIZE_RPC_H_

#include <functional>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/image/decode.h"
#include "server/core/localizer/pose_prior.h"
#include "server/repository/scene_repository.h"
#include "server/service/call.h"
#include "server/service/call_observer.h"
#include "server/service/scene_recognizer.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::service {

// What can be said about options before a query waits: INVALID_ARGUMENT, naming
// the field.
absl::Status CheckOptions(const v1::LocalizeOptions& options);

class LocalizeRpc {
 public:
  LocalizeRpc(const image::DecodeLimits& limits, const base::Clock& clock)
      : limits_(limits), clock_(clock) {}

  // Answers a request that names no scene: ranks scenes by what they look like,
  // and looks for a pose in the best (see LocalizeAmong). `acquire` gives a
  // scene, or says why it cannot be had.
  using AcquireByName =
      std::function<absl::StatusOr<std::shared_ptr<const repository::Scene>>(
          const std::string& name)>;
  absl::StatusOr<v1::LocalizeResponse> HandleAmong(
      const v1::LocalizeRequest& request, const SceneRecognizer& recognizer,
      const AcquireByName& acquire, const CallInfo& call,
      CallRecord& record) const;

  // Answers a request that has just left the queue, on the calling thread.
  // A call whose deadline has passed or that was cancelled costs nothing: it
  // is turned away before anything is decoded. Fills what `record` says of
  // version, outcome and stages. Errors as in relocalization.proto.
  absl::StatusOr<v1::LocalizeResponse> Handle(
      const v1::LocalizeRequest& request, const repository::Scene& scene,
      const CallInfo& call, CallRecord& record) const;

 private:
  absl::StatusOr<v1::LocalizeResponse> Answer(
      absl::StatusOr<localizer::PoseEstimate> estimate,
      const geometry::PosePriors& priors, const repository::Scene& scene,
      const CallInfo& call, CallRecord& record) const;

  const image::DecodeLimits limits_;
  const base::Clock& clock_;
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_LOCALIZE_RPC_H_
