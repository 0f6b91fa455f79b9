// A fixed number of threads behind a queue that is bounded and fair.
#ifndef SERVER_SERVICE_WORKER_POOL_H_
#define SERVER_SERVICE_WORKER_POOL_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <map>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"

namespace treeline::service {

// Runs tasks: of the clients in turn, of one client in the order of their
// submission. Never blocks the one who submits: gRPC's own threads are few, and
// whoever computes or waits on them stops the server. Thread-safe.
class WorkerPool {
 public:
  struct Task {
    // Whose it is: the queue is shared between clients.
    std::string client = {};
    // Tasks of one kind take about the same time: the name of a scene.
    std::string kind = {};
    // When its result is worthless. MonotonicTime::max(): never.
    base::MonotonicTime deadline = base::MonotonicTime::max();
    // Called on a worker. Must not throw.
    std::function<void()> run;
    // Called instead of `run`, from the thread that submitted another task, if
    // this one has to make room for it.
    std::function<void()> give_way = [] {};
  };

  enum class Verdict {
    kAccepted,
    // `queue` tasks wait already, and none of a client with more of them.
    kQueueFull,
    // With what waits before it, it would end after its deadline.
    kTooLate
  };
  struct Admission {
    Verdict verdict = Verdict::kAccepted;
    // Of an accepted task.
    uint64_t ticket = 0;
    // For one that was turned away: when trying again may help.
    std::chrono::milliseconds retry_after{0};
  };

  // workers: threads, at least 1. queue: tasks that may wait, at least 1.
  WorkerPool(int workers, int queue, const base::Clock& clock);
  // Runs what still waits, then joins.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // Takes the task, or says why not. If the queue is full and another client
  // has more tasks in it than this one would have, the last task of the client
  // with the most gives way.
  Admission Submit(Task task);

  // Takes a task back that no worker has begun; then neither `run` nor
  // `give_way` will be called. False: it is running, has run or gave way.
  bool Withdraw(uint64_t ticket);

  int queued() const;
  int running() const;
  int workers() const { return static_cast<int>(threads_.size()); }
  int capacity() const { return static_cast<int>(capacity_); }

 private:
  struct Entry {
    uint64_t ticket = 0;
    double expected_ms = 0;
    Task task;
  };
  // One client's tasks, in order.
  struct Line {
    std::string client;
    std::list<Entry> entries;
  };
  using Lines = std::list<Line>;

  void Work();
  // The next task in turn; there is one.
  Task TakeNext() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Removes one entry, and its line if that was all of it.
  Task Remove(Lines::iterator line, std::list<Entry>::iterator entry)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool WouldBeLate(const Task& task, double task_ms) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Time until a task that `client` submitted now would begin, with all workers
  // busy (ms).
  double ExpectedWait_ms(const std::string& client) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  double Expected_ms(const std::string& kind) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Learn(const std::string& kind, double task_ms)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  std::chrono::milliseconds RetryAfter() const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const size_t capacity_;
  const base::Clock& clock_;
  mutable absl::Mutex mutex_;
  absl::CondVar work_or_stop_;
  // Clients with tasks, the one whose turn it is in front.
  Lines lines_ ABSL_GUARDED_BY(mutex_);
  std::unordered_map<std::string, Lines::iterator> line_of_
      ABSL_GUARDED_BY(mutex_);
  struct Place {
    Lines::iterator line;
    std::list<Entry>::iterator entry;
  };
  std::unordered_map<uint64_t, Place> place_of_ ABSL_GUARDED_BY(mutex_);
  uint64_t last_ticket_ ABSL_GUARDED_BY(mutex_) = 0;
  int running_ ABSL_GUARDED_BY(mutex_) = 0;
  // Of what runs now, as expected when it began (ms).
  double running_ms_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  // Moving averages of durations (ms): of each kind, and of all.
  std::unordered_map<std::string, double> kind_ms_ ABSL_GUARDED_BY(mutex_);
  double any_ms_ ABSL_GUARDED_BY(mutex_) = 0;
  std::vector<std::thread> threads_;
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_WORKER_POOL_H_
