// A Dispatcher for tests: says what it is told to, and remembers.
#ifndef SERVER_GATEWAY_TESTING_DISPATCHER_H_
#define SERVER_GATEWAY_TESTING_DISPATCHER_H_

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "server/service/dispatcher.h"

namespace treeline::gateway {

class TestingDispatcher final : public service::Dispatcher {
 public:
  // Answers Localize; may be replaced before the first call. Runs in the
  // caller's thread.
  std::function<absl::StatusOr<v1::LocalizeResponse>(
      const v1::LocalizeRequest&)>
      on_localize =
          [](const v1::LocalizeRequest&) { return v1::LocalizeResponse(); };
  // With the first, or for the scene of the second, Localize answers CANCELLED
  // once it is asked to stop, and never before.
  bool waits_for_stop = false;
  std::string scene_that_waits = {};

  // What everyone is told who asks to be let in; may be replaced before the
  // first call.
  absl::StatusOr<service::Client> admission = service::Client{.id = "tester"};

  absl::StatusOr<service::Client> Admit(const service::CallInfo& /*call*/,
                                        service::Scope scope) override {
    const absl::MutexLock lock(&mutex_);
    admitted_.push_back(scope);
    return admission;
  }
  absl::StatusOr<service::Client> Identify(const service::CallInfo& /*call*/,
                                           service::Scope /*scope*/) override {
    return admission;
  }
  void Localize(service::CallInfo call, const v1::LocalizeRequest& request,
                Done<v1::LocalizeResponse> done) override {
    Remember(call);
    {
      const absl::MutexLock lock(&mutex_);
      requests_.push_back(request);
    }
    const bool waits = waits_for_stop || (!scene_that_waits.empty() &&
                                          request.scene() == scene_that_waits);
    if (!waits) {
      done(on_localize(request));
      return;
    }
    const auto answer = [done = std::move(done)] {
      done(absl::CancelledError("the client has gone"));
    };
    const absl::MutexLock lock(&mutex_);
    stops_.push_back(
        std::make_unique<std::stop_callback<std::function<void()>>>(
            call.stop, std::function<void()>(answer)));
  }
  void ListScenes(service::CallInfo call,
                  const v1::ListScenesRequest& /*request*/,
                  Done<v1::ListScenesResponse> done) override {
    Remember(call);
    v1::ListScenesResponse response;
    response.add_scenes()->set_scene("kitchen");
    done(response);
  }
  void GetScene(service::CallInfo call, const v1::GetSceneRequest& request,
                Done<v1::GetSceneResponse> done) override {
    Remember(call);
    v1::GetSceneResponse response;
    response.mutable_scene()->set_scene(request.scene());
    done(response);
  }
  void LoadScene(service::CallInfo call, const v1::LoadSceneRequest& request,
                 Done<v1::LoadSceneResponse> done) override {
    Remember(call);
    v1::LoadSceneResponse response;
    response.mutable_scene()->set_scene(request.scene());
    done(response);
  }
  void UnloadScene(service::CallInfo call,
                   const v1::UnloadSceneRequest& request,
                   Done<v1::UnloadSceneResponse> done) override {
    Remember(call);
    v1::UnloadSceneResponse response;
    response.mutable_scene()->set_scene(request.scene());
    done(response);
  }
  void GetSceneMap(service::CallInfo call,
                   const v1::GetSceneMapRequest& request,
                   Done<v1::GetSceneMapResponse> done) override {
    Remember(call);
    v1::GetSceneMapResponse response;
    response.set_scene(request.scene());
    done(response);
  }
  void ListRecentQueries(service::CallInfo call,
                         const v1::ListRecentQueriesRequest& /*request*/,
                         Done<v1::ListRecentQueriesResponse> done) override {
    Remember(call);
    done(v1::ListRecentQueriesResponse());
  }
  void Reject(const service::CallInfo&, const v1::LocalizeRequest& request,
              const absl::Status&) override {
    const absl::MutexLock lock(&mutex_);
    rejected_.push_back(request.scene());
  }
  service::Load load() const override { return {}; }

  // What was asked of Admit so far.
  std::vector<service::Scope> admitted() {
    const absl::MutexLock lock(&mutex_);
    return admitted_;
  }
  // Scenes of what was rejected so far.
  std::vector<std::string> rejected() {
    const absl::MutexLock lock(&mutex_);
    return rejected_;
  }
  // Of all calls so far.
  std::vector<service::CallInfo> calls() {
    const absl::MutexLock lock(&mutex_);
    return calls_;
  }
  std::vector<v1::LocalizeRequest> requests() {
    const absl::MutexLock lock(&mutex_);
    return requests_;
  }
  // Returns when there have been so many calls.
  void AwaitCalls(size_t count) {
    const absl::MutexLock lock(&mutex_);
    const auto enough = [this, count]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
      return calls_.size() >= count;
    };
    mutex_.Await(absl::Condition(&enough));
  }

 private:
  void Remember(const service::CallInfo& call) {
    const absl::MutexLock lock(&mutex_);
    calls_.push_back(call);
  }

  absl::Mutex mutex_;
  std::vector<service::Scope> admitted_ ABSL_GUARDED_BY(mutex_);
  std::vector<service::CallInfo> calls_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::string> rejected_ ABSL_GUARDED_BY(mutex_);
  std::vector<v1::LocalizeRequest> requests_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::unique_ptr<std::stop_callback<std::function<void()>>>> stops_
      ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_TESTING_DISPATCHER_H_
