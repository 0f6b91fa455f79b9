// Calls functions when their time has come.
#ifndef SERVER_SERVICE_DEADLINE_TIMER_H_
#define SERVER_SERVICE_DEADLINE_TIMER_H_

#include <cstdint>
#include <functional>
#include <map>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"

namespace treeline::service {

// One thread for any number of deadlines, on std::chrono::steady_clock. For
// transports that do not watch deadlines themselves. Thread-safe.
class DeadlineTimer {
 public:
  using Key = std::pair<base::MonotonicTime, uint64_t>;

  DeadlineTimer();
  // Forgets what is still armed.
  ~DeadlineTimer();
  DeadlineTimer(const DeadlineTimer&) = delete;
  DeadlineTimer& operator=(const DeadlineTimer&) = delete;

  // Calls `expire`, which must be quick, on the timer's thread once `deadline`
  // has passed.
  Key Arm(base::MonotonicTime deadline, std::function<void()> expire);
  // Forgets it, if it has not begun.
  void Disarm(const Key& key);

 private:
  void Run();

  absl::Mutex mutex_;
  absl::CondVar changed_;
  std::map<Key, std::function<void()>> armed_ ABSL_GUARDED_BY(mutex_);
  uint64_t last_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_DEADLINE_TIMER_H_
