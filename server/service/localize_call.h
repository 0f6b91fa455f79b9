// One query on its way through the dispatcher.
#ifndef SERVER_SERVICE_LOCALIZE_CALL_H_
#define SERVER_SERVICE_LOCALIZE_CALL_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "server/repository/names.h"
#include "server/repository/scene.h"
#include "server/service/call.h"
#include "server/service/call_observer.h"
#include "server/service/deadline_timer.h"
#include "server/service/service_dispatcher.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::service {

// Shared by whoever may end it next: the repository, a worker, the
// timer, the client. The first to claim it does so.
class ServiceDispatcher::LocalizeCall final
    : public std::enable_shared_from_this<LocalizeCall> {
 public:
  LocalizeCall(ServiceDispatcher& service, CallInfo call,
               const v1::LocalizeRequest& request,
               Done<v1::LocalizeResponse> done)
      : service_(service),
        call_(std::move(call)),
        request_(request),
        done_(std::move(done)) {
    service_.CallBegins();
    client_stop_ = std::exchange(call_.stop, stop_.get_token());
    record_.scene = request.scene().substr(0, repository::kLongestName);
    record_.request_bytes = request.ByteSizeLong();
  }
  ~LocalizeCall() { service_.CallEnds(); }

  void Start();

 private:
  // kWaiting: nobody works on it; whoever moves it on from there owns it.
  enum class Stage { kWaiting, kRunning, kEnded };

  absl::Status Admit();
  void UseScene(absl::StatusOr<std::shared_ptr<const repository::Scene>> scene);
  absl::Status Enqueue();
  void Work();
  void OnStop();
  void EndIfWaiting(const absl::Status& status);
  void End(absl::StatusOr<v1::LocalizeResponse> response);
  bool Claim(Stage stage) {
    Stage waiting = Stage::kWaiting;
    return stage_.compare_exchange_strong(waiting, stage);
  }

  ServiceDispatcher& service_;
  CallInfo call_;
  const v1::LocalizeRequest& request_;
  Done<v1::LocalizeResponse> done_;
  CallRecord record_;
  std::string client_;
  std::shared_ptr<const repository::Scene> scene_;

  std::atomic<Stage> stage_{Stage::kWaiting};
  std::atomic<bool> counted_as_waiting_{false};
  absl::Mutex mutex_;
  std::optional<uint64_t> ticket_ ABSL_GUARDED_BY(mutex_);
  std::optional<DeadlineTimer::Key> timer_key_ ABSL_GUARDED_BY(mutex_);

  std::stop_source stop_;
  std::stop_token client_stop_;
  std::optional<std::stop_callback<std::function<void()>>> on_client_stop_;
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_LOCALIZE_CALL_H_
