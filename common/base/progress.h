// A progress line on a terminal, or a plain line now and then in a log.
#ifndef COMMON_BASE_PROGRESS_H_
#define COMMON_BASE_PROGRESS_H_

#include <cstdint>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"

namespace treeline::base {

// Writes "label [#####.....] 52 %  12 s left" to standard error: redrawn in
// place at most ten times a second on a terminal, one line every ten seconds
// elsewhere. Thread-safe. Finishes its line when destroyed.
class Progress {
 public:
  // total: units of work, at least 1. quiet: write nothing.
  Progress(std::string label, int64_t total, bool quiet = false);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Add(int64_t units);

 private:
  void Draw(MonotonicTime now, bool last) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string label_;
  const int64_t total_;
  const bool quiet_;
  const bool terminal_;
  const MonotonicTime start_;
  absl::Mutex mutex_;
  int64_t done_ ABSL_GUARDED_BY(mutex_) = 0;
  MonotonicTime next_draw_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::base

#endif  // COMMON_BASE_PROGRESS_H_
