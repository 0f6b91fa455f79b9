// What calls are told that find no place, or no end.
#ifndef SERVER_SERVICE_OVERLOAD_H_
#define SERVER_SERVICE_OVERLOAD_H_

#include <atomic>
#include <chrono>

#include "absl/status/status.h"

namespace treeline::service {

// UNAVAILABLE, reason QUEUE_FULL.
absl::Status QueueIsFull(
    std::chrono::milliseconds retry_after = std::chrono::milliseconds(100));

// INTERNAL: something was thrown; what it was is for the log alone.
absl::Status InternalFault();

// Whether a call that no worker had begun was ended by too much work.
bool IsShed(const absl::Status& status);

// Places for calls that wait, and hold no place in the queue of the workers.
// Thread-safe.
class WaitingRoom {
 public:
  explicit WaitingRoom(int places) : places_(places) {}

  // False: there is no place.
  bool Enter() {
    if (waiting_.fetch_add(1) < places_) return true;
    waiting_.fetch_sub(1);
    return false;
  }
  // Once for each that has entered.
  void Leave() { waiting_.fetch_sub(1); }
  int waiting() const { return waiting_; }

 private:
  const int places_;
  std::atomic<int> waiting_{0};
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_OVERLOAD_H_
