// When independent clients would ask.
#ifndef CLIENT_BENCH_ARRIVALS_H_
#define CLIENT_BENCH_ARRIVALS_H_

#include <cmath>
#include <cstdint>

#include "common/base/random.h"

namespace treeline::bench {

// A Poisson process: the same seed and rate give the same times.
class PoissonArrivals {
 public:
  // rate_per_s > 0.
  PoissonArrivals(uint64_t seed, double rate_per_s)
      : random_(seed, kStream), rate_per_s_(rate_per_s) {}

  // Seconds from the start to the next arrival; grows.
  double Next_s() {
    at_s_ -= std::log(1 - random_.NextUnit()) / rate_per_s_;
    return at_s_;
  }

 private:
  static constexpr uint64_t kStream = 1;

  base::Random random_;
  const double rate_per_s_;
  double at_s_ = 0;
};

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_ARRIVALS_H_
