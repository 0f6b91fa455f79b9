// Waiting for the Dispatcher in the thread of an HTTP connection.
#ifndef SERVER_GATEWAY_PENDING_CALL_H_
#define SERVER_GATEWAY_PENDING_CALL_H_

#include <memory>
#include <optional>
#include <stop_token>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "server/service/call.h"
#include "server/service/dispatcher.h"

namespace treeline::gateway {

// Wakes a waiting thread that watches a socket too.
class CallSignal {
 public:
  CallSignal();
  ~CallSignal();
  CallSignal(const CallSignal&) = delete;
  CallSignal& operator=(const CallSignal&) = delete;

  // False: the system has no descriptor left.
  bool is_valid() const { return fd_ >= 0; }
  void Notify() const;
  // For poll(): can be read after Notify(), until Clear(), which is for then.
  int fd() const { return fd_; }
  void Clear() const;
  // Returns after Notify(). Requests a stop as soon as `socket` (-1: none) says
  // that its client has closed or given up, and at `deadline`.
  void Wait(int socket, base::MonotonicTime deadline, const base::Clock& clock,
            std::stop_source& stop) const;

 private:
  const int fd_;
};

// CANCELLED after the deadline means that the deadline has cancelled it.
absl::Status DeadlineInsteadOfCancelled(absl::Status status,
                                        base::MonotonicTime deadline,
                                        const base::Clock& clock);

// Makes a call of a Dispatcher and waits for its answer. A client that closes
// its connection, or its half of it, has left: the call is asked to stop.
template <typename Request, typename Response>
absl::StatusOr<Response> CallAndWait(
    service::Dispatcher& dispatcher,
    void (service::Dispatcher::*method)(service::CallInfo, const Request&,
                                        service::Dispatcher::Done<Response>),
    service::CallInfo call, const Request& request, int socket,
    const base::Clock& clock) {
  struct State {
    CallSignal signal;
    absl::Mutex mutex;
    std::optional<absl::StatusOr<Response>> answer ABSL_GUARDED_BY(mutex);
  };
  // Shared, for Notify() may still be on its way out when we have woken.
  const auto state = std::make_shared<State>();
  if (!state->signal.is_valid()) {
    return absl::UnavailableError("too many calls at a time");
  }
  std::stop_source stop;
  call.stop = stop.get_token();
  const base::MonotonicTime deadline = call.deadline;
  (dispatcher.*method)(std::move(call), request,
                       [state](absl::StatusOr<Response> answer) {
                         {
                           const absl::MutexLock lock(&state->mutex);
                           state->answer = std::move(answer);
                         }
                         state->signal.Notify();
                       });
  state->signal.Wait(socket, deadline, clock, stop);
  const absl::MutexLock lock(&state->mutex);
  if (!state->answer->ok()) {
    return DeadlineInsteadOfCancelled(state->answer->status(), deadline, clock);
  }
  return *std::move(state->answer);
}

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_PENDING_CALL_H_
