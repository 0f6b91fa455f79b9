// The service itself: what every transport calls.
#ifndef SERVER_SERVICE_SERVICE_DISPATCHER_H_
#define SERVER_SERVICE_SERVICE_DISPATCHER_H_

#include <atomic>
#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "common/image/decode.h"
#include "common/tracing/tracer.h"
#include "server/repository/scene_repository.h"
#include "server/service/access_policy.h"
#include "server/service/call_observer.h"
#include "server/service/deadline_timer.h"
#include "server/service/dispatcher.h"
#include "server/service/localize_rpc.h"
#include "server/service/overload.h"
#include "server/service/recent_queries.h"
#include "server/service/scene_maps.h"
#include "server/service/scene_recognizer.h"
#include "server/service/worker_pool.h"

namespace treeline::service {

struct DispatcherOptions {
  // Queries computed at a time, 1..1024; 0: one per processor.
  int workers = 0;
  // Queries that may wait for a worker or for their scene, 1..100000.
  int queue = 64;
  image::DecodeLimits decode_limits = {};
  // What ListRecentQueries tells of; null: nothing. Must outlive the
  // dispatcher.
  const RecentQueries* recent_queries = nullptr;
  // Gives calls their spans; null: they have none. Must outlive the dispatcher.
  tracing::Tracer* tracer = nullptr;

  absl::Status Validate() const;
};

// A query goes through here: access -> place in the queue -> scene, loaded if
// it is not -> worker -> answer. Whatever ends it on the way, its place is free
// at once, and one record of it is made.
class ServiceDispatcher final : public Dispatcher {
 public:
  // All must outlive it.
  ServiceDispatcher(repository::SceneRepository& repository,
                    AccessPolicy& access, CallObserver& observer,
                    const base::Clock& clock, const DispatcherOptions& options);
  // Waits for the calls that are left.
  ~ServiceDispatcher() override;

  absl::StatusOr<Client> Admit(const CallInfo& call, Scope scope) override;
  absl::StatusOr<Client> Identify(const CallInfo& call, Scope scope) override;
  void Localize(CallInfo call, const v1::LocalizeRequest& request,
                Done<v1::LocalizeResponse> done) override;
  void ListScenes(CallInfo call, const v1::ListScenesRequest& request,
                  Done<v1::ListScenesResponse> done) override;
  void GetScene(CallInfo call, const v1::GetSceneRequest& request,
                Done<v1::GetSceneResponse> done) override;
  void LoadScene(CallInfo call, const v1::LoadSceneRequest& request,
                 Done<v1::LoadSceneResponse> done) override;
  void UnloadScene(CallInfo call, const v1::UnloadSceneRequest& request,
                   Done<v1::UnloadSceneResponse> done) override;
  void GetSceneMap(CallInfo call, const v1::GetSceneMapRequest& request,
                   Done<v1::GetSceneMapResponse> done) override;
  void ListRecentQueries(CallInfo call,
                         const v1::ListRecentQueriesRequest& request,
                         Done<v1::ListRecentQueriesResponse> done) override;
  void Reject(const CallInfo& call, const v1::LocalizeRequest& request,
              const absl::Status& status) override;
  Load load() const override;

 private:
  class LocalizeCall;

  // A scene for a query on a worker that names none. Waits for it to be loaded
  // as long as other workers do not wait too; then, it is tried without.
  absl::StatusOr<std::shared_ptr<const repository::Scene>> AcquireOnWorker(
      const std::string& name, const std::stop_token& stop);

  // Of a call that has been let in already, or asks whether it is.
  absl::StatusOr<std::string> ClientOf(const CallInfo& call, Scope scope);
  // Reports a refusal.
  absl::StatusOr<Client> OrReport(const CallInfo& call,
                                  absl::StatusOr<Client> client);

  // Ends a call: gives its record what all records have, and reports it.
  absl::Status Report(const CallInfo& call, const absl::Status& status,
                      CallRecord& record);
  // Runs `answer` and reports it: for calls that need no worker.
  template <typename Response, typename Answer>
  void AnswerNow(const CallInfo& call, const std::string& scene, Scope scope,
                 const Done<Response>& done, Answer answer);

  void CallBegins();
  void CallEnds();

  repository::SceneRepository& repository_;
  AccessPolicy& access_;
  CallObserver& observer_;
  const base::Clock& clock_;
  const LocalizeRpc localize_;
  const SceneRecognizer recognizer_;
  const RecentQueries* const recent_queries_;
  tracing::Tracer* const tracer_;
  // Calls whose scene is being loaded.
  WaitingRoom waiting_for_scene_;
  SceneMaps scene_maps_;
  // Workers that wait for a scene.
  std::atomic<int> waiting_workers_{0};
  absl::Mutex mutex_;
  int calls_ ABSL_GUARDED_BY(mutex_) = 0;
  // Last, so that their threads end first.
  DeadlineTimer timer_;
  WorkerPool workers_;
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_SERVICE_DISPATCHER_H_
