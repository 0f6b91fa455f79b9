// Lets one thread at a time, and at most once in an interval, look whether
// something has changed; the others go on with what they have.
#ifndef SERVER_ACCESS_POLL_GATE_H_
#define SERVER_ACCESS_POLL_GATE_H_

#include <chrono>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"

namespace treeline::access {

// Thread-safe.
class PollGate {
 public:
  // The first poll is due one interval after `now`.
  PollGate(base::MonotonicTime now, std::chrono::milliseconds interval)
      : interval_(interval), next_(now + interval) {}

  // Whether the caller shall poll now; if so it calls Done() afterwards.
  bool Enter(base::MonotonicTime now) {
    const absl::MutexLock lock(&mutex_);
    if (polling_ || now < next_) return false;
    polling_ = true;
    next_ = now + interval_;
    return true;
  }
  void Done() {
    const absl::MutexLock lock(&mutex_);
    polling_ = false;
  }

 private:
  const std::chrono::milliseconds interval_ = {};
  absl::Mutex mutex_;
  base::MonotonicTime next_ ABSL_GUARDED_BY(mutex_);
  bool polling_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace treeline::access

#endif  // SERVER_ACCESS_POLL_GATE_H_
