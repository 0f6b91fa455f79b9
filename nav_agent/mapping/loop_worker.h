// A loop closer on a thread of its own.
#ifndef NAV_AGENT_MAPPING_LOOP_WORKER_H_
#define NAV_AGENT_MAPPING_LOOP_WORKER_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <stop_token>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "nav_agent/mapping/loop_closer.h"

namespace treeline::mapping {

// Thread-safe. Keyscans that wait when it is destroyed are not looked at.
class LoopWorker {
 public:
  // synchronous: there is no thread; calls do the work and return then.
  LoopWorker(LoopCloser closer, bool synchronous);
  ~LoopWorker();
  LoopWorker(const LoopWorker&) = delete;
  LoopWorker& operator=(const LoopWorker&) = delete;

  void Add(NewKeyscan job) ABSL_LOCKS_EXCLUDED(mutex_);
  // The places of the first keyscans, if they have changed since the last
  // call.
  std::optional<std::vector<KeyscanPlace>> TakeCorrection()
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns when all that was added has been looked at, and polished.
  void Finish(int polish_rounds) ABSL_LOCKS_EXCLUDED(mutex_);
  LoopCloserStatistics Statistics() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Job {
    NewKeyscan keyscan = {};
    int polish_rounds = 0;  // above 0: no keyscan
  };

  void Run(const std::stop_token& stop);
  void Do(const Job& job);
  void Put(Job job) ABSL_LOCKS_EXCLUDED(mutex_);

  const bool synchronous_;
  LoopCloser closer_;  // of the thread that runs it
  mutable absl::Mutex mutex_;
  // A job has come, or the end; all jobs are done.
  absl::CondVar wake_;
  absl::CondVar idle_;
  std::deque<Job> jobs_ ABSL_GUARDED_BY(mutex_);
  bool busy_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<std::vector<KeyscanPlace>> correction_ ABSL_GUARDED_BY(mutex_);
  LoopCloserStatistics statistics_ ABSL_GUARDED_BY(mutex_);
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_LOOP_WORKER_H_
