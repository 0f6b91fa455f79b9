// Monotonic time for durations. Injected, so that tests need not wait.
#ifndef COMMON_BASE_CLOCK_H_
#define COMMON_BASE_CLOCK_H_

#include <chrono>

namespace treeline::base {

using MonotonicTime = std::chrono::steady_clock::time_point;

class Clock {
 public:
  virtual ~Clock() = default;
  virtual MonotonicTime Now() const = 0;
};

class SteadyClock final : public Clock {
 public:
  MonotonicTime Now() const override {
    return std::chrono::steady_clock::now();
  }
};

// Milliseconds from `start` to `end`.
inline double MillisecondsBetween(MonotonicTime start, MonotonicTime end) {
  return std::chrono::duration<double, std::milli>(end - start).count();
}

// Seconds from `from` to `to`.
inline double SecondsBetween(MonotonicTime from, MonotonicTime to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace treeline::base

#endif  // COMMON_BASE_CLOCK_H_
