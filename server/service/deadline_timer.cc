#include "server/service/deadline_timer.h"

#include <algorithm>

#include "absl/time/time.h"

namespace treeline::service {

DeadlineTimer::DeadlineTimer() : thread_([this] { Run(); }) {}

DeadlineTimer::~DeadlineTimer() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
    changed_.SignalAll();
  }
  thread_.join();
}

DeadlineTimer::Key DeadlineTimer::Arm(base::MonotonicTime deadline,
                                      std::function<void()> expire) {
  absl::MutexLock lock(&mutex_);
  const Key key{deadline, ++last_};
  const auto entry = armed_.emplace(key, std::move(expire)).first;
  if (entry == armed_.begin()) changed_.Signal();
  return key;
}

void DeadlineTimer::Disarm(const Key& key) {
  // Destroyed when the lock is released: it may own the one who asks.
  std::function<void()> expire;
  absl::MutexLock lock(&mutex_);
  const auto entry = armed_.find(key);
  if (entry == armed_.end()) return;
  expire = std::move(entry->second);
  armed_.erase(entry);
}

void DeadlineTimer::Run() {
  absl::MutexLock lock(&mutex_);
  while (!stopping_) {
    if (armed_.empty()) {
      changed_.Wait(&mutex_);
      continue;
    }
    const auto first = armed_.begin();
    const auto left = first->first.first - std::chrono::steady_clock::now();
    if (left > base::MonotonicTime::duration::zero()) {
      changed_.WaitWithTimeout(&mutex_, absl::FromChrono(left));
      continue;
    }
    std::function<void()> expire = std::move(first->second);
    armed_.erase(first);
    mutex_.Unlock();
    expire();
    expire = nullptr;
    mutex_.Lock();
  }
}

}  // namespace treeline::service
