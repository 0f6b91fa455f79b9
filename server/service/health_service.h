// grpc.health.v1: what balancers and probes ask.
#ifndef SERVER_SERVICE_HEALTH_SERVICE_H_
#define SERVER_SERVICE_HEALTH_SERVICE_H_

#include <map>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "common/grpc_server/raw_service.h"
#include "grpc/health/v1/health.pb.h"
#include "server/service/dispatcher.h"
#include "server/service/grpc_call.h"

namespace treeline::service {

using ServingStatus = grpc::health::v1::HealthCheckResponse::ServingStatus;

// Check and Watch. gRPC's own service tells everyone about every name, and
// reads requests of any size. Here "", the whole server, is told to all; a
// scene (HealthServiceOf) to who may localize, on an admin listener to who may
// administer. Thread-safe.
class HealthGrpcService final : public grpc_server::RawService {
 public:
  // All must outlive the server that the service is registered with.
  HealthGrpcService(Dispatcher& dispatcher, const CallSource& source);

  // "" is serving from the start.
  void Set(const std::string& name, bool is_serving);
  // Everything is NOT_SERVING, whatever is set afterwards.
  void Stop();

 private:
  class Call;

  // OK: the client may know about `name`.
  absl::Status MayAsk(const grpc::CallbackServerContext& context,
                      const std::string& name);
  ServingStatus Get(const std::string& name);
  // False: too many watch already.
  bool Watch(Call* call);
  void Unwatch(Call* call);
  void TellWatchers() ABSL_LOCKS_EXCLUDED(mutex_);

  Dispatcher& dispatcher_;
  const CallSource source_;
  absl::Mutex mutex_;
  std::map<std::string, bool> serving_ ABSL_GUARDED_BY(mutex_) = {{"", true}};
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::map<Call*, std::weak_ptr<Call>> watchers_ ABSL_GUARDED_BY(mutex_);
};

// The name in a HealthCheckRequest. INVALID_ARGUMENT: it is none.
absl::StatusOr<std::string> DecodeHealthRequest(absl::string_view bytes);

}  // namespace treeline::service

#endif  // SERVER_SERVICE_HEALTH_SERVICE_H_
