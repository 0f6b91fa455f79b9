// Things to do later, on one thread.
#ifndef CLIENT_BENCH_TIMER_H_
#define CLIENT_BENCH_TIMER_H_

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <stop_token>
#include <thread>

#include "common/base/clock.h"

namespace treeline::bench {

// Thread-safe. Actions run on the timer's thread, one after the other, and must
// be quick; what is not due when the timer is destroyed is dropped.
class Timer {
 public:
  Timer() : thread_([this](const std::stop_token& stop) { Run(stop); }) {}
  ~Timer();
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;

  void At(base::MonotonicTime due, std::function<void()> action);

 private:
  void Run(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::multimap<base::MonotonicTime, std::function<void()>>
      actions_;          // by mutex_
  std::jthread thread_;  // the last: it uses the others
};

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_TIMER_H_
