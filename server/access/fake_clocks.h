// Clocks that stand until a test moves them. Thread-safe.
#ifndef SERVER_ACCESS_FAKE_CLOCKS_H_
#define SERVER_ACCESS_FAKE_CLOCKS_H_

#include <atomic>
#include <chrono>
#include <cstdint>

#include "common/base/clock.h"
#include "server/access/wall_clock.h"

namespace treeline::access {

class FakeClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override {
    return base::MonotonicTime(std::chrono::nanoseconds(now_ns_.load()));
  }
  void Advance(std::chrono::nanoseconds by) { now_ns_ += by.count(); }

 private:
  std::atomic<int64_t> now_ns_ = 1'000'000'000;
};

class FakeWallClock final : public WallClock {
 public:
  explicit FakeWallClock(int64_t unix_s) : unix_s_(unix_s) {}
  int64_t UnixSeconds() const override { return unix_s_; }
  void Set(int64_t unix_s) { unix_s_ = unix_s; }

 private:
  std::atomic<int64_t> unix_s_ = 0;
};

}  // namespace treeline::access

#endif  // SERVER_ACCESS_FAKE_CLOCKS_H_
