// Pictures of scenes, from the keyframes of their models.
#ifndef SERVER_SERVICE_SCENE_MAPS_H_
#define SERVER_SERVICE_SCENE_MAPS_H_

#include <functional>
#include <map>
#include <memory>
#include <stop_token>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "server/repository/scene.h"
#include "server/repository/scene_repository.h"
#include "server/service/overload.h"
#include "server/service/worker_pool.h"
#include "treeline/v1/scenes.pb.h"

namespace treeline::service {

// Thread-safe.
class SceneMaps {
 public:
  struct Call {
    v1::GetSceneMapRequest request;
    // Whose turn it is taken in.
    std::string client;
    base::MonotonicTime deadline = base::MonotonicTime::max();
    std::stop_token stop;
    // Called before `done` with what was thrown, if something was.
    std::function<void(const char* what)> on_fault = [](const char*) {};
    // Called exactly once, at once or later from another thread.
    std::function<void(absl::StatusOr<v1::GetSceneMapResponse>)> done;
  };

  // All must outlive it; `workers` may run what is left of it to the end. In
  // `waiting_for_scene` calls wait until their scene is loaded.
  SceneMaps(repository::SceneRepository& repository, WorkerPool& workers,
            WaitingRoom& waiting_for_scene, const base::Clock& clock)
      : repository_(repository),
        workers_(workers),
        waiting_for_scene_(waiting_for_scene),
        clock_(clock) {}

  // Does not block: the map is made on a worker. Errors as of the RPC, of
  // SceneRepository::AcquireAsync and, with reason QUEUE_FULL, of the pool or
  // of the calls that wait.
  void Start(Call call);

  // In the calling thread. The first who asks for a version's coverage computes
  // it; meanwhile others are told to try again.
  absl::StatusOr<v1::GetSceneMapResponse> Make(
      const v1::GetSceneMapRequest& request, const repository::Scene& scene);

 private:
  // What is kept of a scene's newest version.
  struct Kept {
    // Which it is of: never read.
    std::weak_ptr<const localizer::Localizer> localizer;
    // Null: it is being computed.
    std::shared_ptr<const v1::SceneCoverage> coverage;
  };

  absl::StatusOr<v1::GetSceneMapResponse> MakeOrFault(
      const Call& call, const repository::Scene& scene);
  absl::StatusOr<std::shared_ptr<const v1::SceneCoverage>> CoverageOf(
      const repository::Scene& scene);

  // Takes no coverage as being computed that is not.
  void ForgetUnlessKept(const repository::Scene& scene);
  void Enqueue(const std::shared_ptr<Call>& call,
               std::shared_ptr<const repository::Scene> scene);

  repository::SceneRepository& repository_;
  WorkerPool& workers_;
  WaitingRoom& waiting_for_scene_;
  const base::Clock& clock_;
  absl::Mutex mutex_;
  // By name, of the scenes that there are: names come from loaded ones.
  std::map<std::string, Kept> kept_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_SCENE_MAPS_H_
