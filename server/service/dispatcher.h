// Where all transports come together: access, admission, workers, records.
#ifndef SERVER_SERVICE_DISPATCHER_H_
#define SERVER_SERVICE_DISPATCHER_H_

#include <functional>

#include "absl/status/statusor.h"
#include "server/service/access_policy.h"
#include "server/service/call.h"
#include "treeline/v1/relocalization.pb.h"
#include "treeline/v1/scenes.pb.h"

namespace treeline::service {

// Calls in the service now.
struct Load {
  int queued = 0;
  int waiting_for_scene = 0;
  int running = 0;
  int workers = 0;
  int queue_capacity = 0;
};

// The RPCs, whatever carries them. No method blocks; each calls `done` exactly
// once, at once or later from another thread, with the answer or with a status
// that carries a reason and, where trying again helps, a time (see
// common/base/error_info.h). `request` must stay until then. Every call is
// reported to the CallObserver exactly once, before `done`. Thread-safe.
class Dispatcher {
 public:
  template <typename Response>
  using Done = std::function<void(absl::StatusOr<Response>)>;

  virtual ~Dispatcher() = default;

  // What AccessPolicy::Admit says, for transports: to be asked before the
  // request of `call` is read, with what is known by then. A refusal is
  // reported as the end of the call.
  virtual absl::StatusOr<Client> Admit(const CallInfo& call, Scope scope) = 0;
  // The same with AccessPolicy::Identify.
  virtual absl::StatusOr<Client> Identify(const CallInfo& call,
                                          Scope scope) = 0;

  virtual void Localize(CallInfo call, const v1::LocalizeRequest& request,
                        Done<v1::LocalizeResponse> done) = 0;
  virtual void ListScenes(CallInfo call, const v1::ListScenesRequest& request,
                          Done<v1::ListScenesResponse> done) = 0;
  virtual void GetScene(CallInfo call, const v1::GetSceneRequest& request,
                        Done<v1::GetSceneResponse> done) = 0;
  virtual void LoadScene(CallInfo call, const v1::LoadSceneRequest& request,
                         Done<v1::LoadSceneResponse> done) = 0;
  virtual void UnloadScene(CallInfo call, const v1::UnloadSceneRequest& request,
                           Done<v1::UnloadSceneResponse> done) = 0;

  virtual void GetSceneMap(CallInfo call, const v1::GetSceneMapRequest& request,
                           Done<v1::GetSceneMapResponse> done) = 0;
  virtual void ListRecentQueries(CallInfo call,
                                 const v1::ListRecentQueriesRequest& request,
                                 Done<v1::ListRecentQueriesResponse> done) = 0;

  // Reports a query that a transport turned away itself: there were too many.
  virtual void Reject(const CallInfo& call, const v1::LocalizeRequest& request,
                      const absl::Status& status) = 0;

  virtual Load load() const = 0;
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_DISPATCHER_H_
