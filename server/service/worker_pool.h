// A fixed number of threads behind a queue of bounded length.
#ifndef SERVER_SERVICE_WORKER_POOL_H_
#define SERVER_SERVICE_WORKER_POOL_H_

#include <deque>
#include <functional>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"

namespace treeline {

// Runs tasks in the order of their submission. Never blocks the one who
// submits: gRPC's own threads are few, and whoever computes or waits on them
// stops the server. Thread-safe.
class WorkerPool {
 public:
  // workers: threads, at least 1. queue: tasks that may wait, at least 1.
  WorkerPool(int workers, int queue, const Clock& clock);
  // Runs what still waits, then joins.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // Takes the task, or returns false because `queue` tasks wait already. A
  // task must not throw.
  bool TrySubmit(std::function<void()> task);

  // How long the tasks that wait now will take all workers, estimated from the
  // duration of recent tasks (ms). 0 before the first task has ended.
  double BacklogEstimate_ms() const;

 private:
  void Work();

  const size_t workers_;
  const size_t capacity_;
  const Clock& clock_;
  mutable absl::Mutex mutex_;
  absl::CondVar work_or_stop_;
  std::deque<std::function<void()>> queue_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  // Moving average; 0: no task has ended yet.
  double task_ms_ ABSL_GUARDED_BY(mutex_) = 0;
  std::vector<std::thread> threads_;
};

}  // namespace treeline

#endif  // SERVER_SERVICE_WORKER_POOL_H_
