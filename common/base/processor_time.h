// What a thread's work cost.
#ifndef COMMON_BASE_PROCESSOR_TIME_H_
#define COMMON_BASE_PROCESSOR_TIME_H_

#include <chrono>
#include <ctime>

#include "common/base/clock.h"

namespace treeline::base {

// Processor time that the calling thread has used so far (ms). Time in which
// others had the processor does not count.
inline double ThreadProcessorTime_ms() {
  timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) +
         1e-6 * static_cast<double>(time.tv_nsec);
}

// The same as a clock: of the thread that asks, so only within one thread.
class ThreadProcessorClock final : public Clock {
 public:
  MonotonicTime Now() const override {
    return MonotonicTime(std::chrono::duration_cast<MonotonicTime::duration>(
        std::chrono::duration<double, std::milli>(ThreadProcessorTime_ms())));
  }
};

}  // namespace treeline::base

#endif  // COMMON_BASE_PROCESSOR_TIME_H_
