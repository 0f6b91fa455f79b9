// A driver and its emulated sensor, for tests.
#ifndef SIMULATION_EMULATORS_TESTING_LASER_H_
#define SIMULATION_EMULATORS_TESTING_LASER_H_

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "common/base/clock.h"

namespace treeline::emulators {

// A clock that is set by hand.
class ManualClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override { return now_; }
  void Advance(double seconds) {
    now_ += std::chrono::duration_cast<base::MonotonicTime::duration>(
        std::chrono::duration<double>(seconds));
  }

 private:
  base::MonotonicTime now_ = base::MonotonicTime() + std::chrono::hours(1);
};

// Looks every millisecond whether `condition` holds; false if it does not
// within 20 s, of which a test that passes sees little.
inline bool Eventually(const std::function<bool()>& condition) {
  const auto deadline =
      std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace treeline::emulators

#endif  // SIMULATION_EMULATORS_TESTING_LASER_H_
