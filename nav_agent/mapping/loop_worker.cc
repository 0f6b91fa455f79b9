#include "nav_agent/mapping/loop_worker.h"

#include <utility>

namespace treeline::mapping {

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
    wake_.Signal();
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
  wake_.Signal();
}

void LoopWorker::Add(NewKeyscan job) { Put({.keyscan = std::move(job)}); }

void LoopWorker::Do(const Job& job) {
  bool changed = true;
  if (job.polish_rounds > 0) {
    closer_.Polish(job.polish_rounds);
  } else {
    changed = closer_.Add(job.keyscan);
  }
  const absl::MutexLock lock(&mutex_);
  if (changed) correction_ = closer_.Places();
  statistics_ = closer_.statistics();
}

void LoopWorker::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    Job job;
    {
      const absl::MutexLock lock(&mutex_);
      while (!stopping_ && jobs_.empty()) wake_.Wait(&mutex_);
      if (stopping_) return;
      job = std::move(jobs_.front());
      jobs_.pop_front();
      busy_ = true;
    }
    Do(job);
    const absl::MutexLock lock(&mutex_);
    busy_ = false;
    if (jobs_.empty()) idle_.SignalAll();
  }
}

std::optional<std::vector<KeyscanPlace>> LoopWorker::TakeCorrection() {
  const absl::MutexLock lock(&mutex_);
  return std::exchange(correction_, std::nullopt);
}

void LoopWorker::Finish(int polish_rounds) {
  if (polish_rounds > 0) Put({.polish_rounds = polish_rounds});
  const absl::MutexLock lock(&mutex_);
  while (busy_ || !jobs_.empty()) idle_.Wait(&mutex_);
}

LoopCloserStatistics LoopWorker::Statistics() const {
  const absl::MutexLock lock(&mutex_);
  return statistics_;
}

}  // namespace treeline::mapping
