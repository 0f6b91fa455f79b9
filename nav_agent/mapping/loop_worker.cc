#include "nav_agent/mapping/loop_worker.h"

#include <utility>

namespace treeline {

LoopWorker::LoopWorker(LoopCloser closer, bool synchronous)
    : synchronous_(synchronous), closer_(std::move(closer)) {
  if (!synchronous_) {
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
}

LoopWorker::~LoopWorker() {
  {
    const absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  thread_.request_stop();
}

void LoopWorker::Put(Job job) {
  if (synchronous_) {
    Do(job);
    return;
  }
  const absl::MutexLock lock(&mutex_);
  jobs_.push_back(std::move(job));
}

void LoopWorker::Add(KeyscanJob job) { Put({.keyscan = std::move(job)}); }

void LoopWorker::Do(const Job& job) {
  bool changed = true;
  if (job.polish_rounds > 0) {
    closer_.Polish(job.polish_rounds);
  } else {
    changed =
        closer_.Add(job.keyscan.scan, job.keyscan.previous_from_this,
                    job.keyscan.covariance);
  }
  const absl::MutexLock lock(&mutex_);
  if (changed) correction_ = closer_.map_from_keyscans();
  statistics_ = closer_.statistics();
}

void LoopWorker::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    Job job;
    {
      const absl::MutexLock lock(&mutex_);
      mutex_.Await(absl::Condition(this, &LoopWorker::HasJobOrStops));
      if (stopping_) return;
      job = std::move(jobs_.front());
      jobs_.pop_front();
      busy_ = true;
    }
    Do(job);
    const absl::MutexLock lock(&mutex_);
    busy_ = false;
  }
}

std::optional<std::vector<Rigid2>> LoopWorker::TakeCorrection() {
  const absl::MutexLock lock(&mutex_);
  return std::exchange(correction_, std::nullopt);
}

void LoopWorker::Finish(int polish_rounds) {
  if (polish_rounds > 0) Put({.polish_rounds = polish_rounds});
  const absl::MutexLock lock(&mutex_);
  mutex_.Await(absl::Condition(this, &LoopWorker::IsIdle));
}

LoopCloserStatistics LoopWorker::Statistics() const {
  const absl::MutexLock lock(&mutex_);
  return statistics_;
}

}  // namespace treeline
