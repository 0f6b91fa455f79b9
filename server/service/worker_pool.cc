#include "server/service/worker_pool.h"

#include <algorithm>
#include <utility>

namespace treeline {
namespace {

// Weight of the latest task in the average of durations.
constexpr double kNewWeight = 0.1;

}  // namespace

WorkerPool::WorkerPool(int workers, int queue, const Clock& clock)
    : workers_(static_cast<size_t>(std::max(workers, 1))),
      capacity_(static_cast<size_t>(std::max(queue, 1))),
      clock_(clock) {
  for (size_t i = 0; i < workers_; ++i) {
    threads_.emplace_back([this] { Work(); });
  }
}

WorkerPool::~WorkerPool() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
    work_or_stop_.SignalAll();
  }
  for (std::thread& thread : threads_) thread.join();
}

bool WorkerPool::TrySubmit(std::function<void()> task) {
  absl::MutexLock lock(&mutex_);
  if (queue_.size() >= capacity_) return false;
  queue_.push_back(std::move(task));
  work_or_stop_.Signal();
  return true;
}

double WorkerPool::BacklogEstimate_ms() const {
  absl::MutexLock lock(&mutex_);
  return task_ms_ * static_cast<double>(queue_.size()) /
         static_cast<double>(workers_);
}

void WorkerPool::Work() {
  while (true) {
    std::function<void()> task;
    {
      absl::MutexLock lock(&mutex_);
      while (queue_.empty() && !stopping_) work_or_stop_.Wait(&mutex_);
      if (queue_.empty()) return;
      task = std::move(queue_.front());
      queue_.pop_front();
    }
    const MonotonicTime start = clock_.Now();
    task();
    const double task_ms = MillisecondsBetween(start, clock_.Now());
    absl::MutexLock lock(&mutex_);
    task_ms_ = task_ms_ == 0
                   ? task_ms
                   : (1 - kNewWeight) * task_ms_ + kNewWeight * task_ms;
  }
}

}  // namespace treeline
