#include "client/bench/timer.h"

#include <utility>

namespace treeline::bench {

Timer::~Timer() {
  thread_.request_stop();
  thread_.join();
}

void Timer::At(base::MonotonicTime due, std::function<void()> action) {
  {
    const std::lock_guard lock(mutex_);
    actions_.emplace(due, std::move(action));
  }
  changed_.notify_one();
}

void Timer::Run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    if (actions_.empty()) {
      changed_.wait(lock, stop, [this] { return !actions_.empty(); });
      continue;
    }
    const base::MonotonicTime due = actions_.begin()->first;
    if (std::chrono::steady_clock::now() < due) {
      changed_.wait_until(lock, stop, due, [this, due] {
        return actions_.begin()->first < due;
      });
      continue;
    }
    const std::function<void()> action =
        std::move(actions_.extract(actions_.begin()).mapped());
    lock.unlock();
    action();
    lock.lock();
  }
}

}  // namespace treeline::bench
