#include "client/bench/arrivals.h"

#include <cmath>

#include "gtest/gtest.h"

namespace treeline::bench {
namespace {

// Of 10000 gaps the mean is known to 1 %, the share longer than the mean
// (1/e) to 0.5 %: four of these sigmas.
TEST(PoissonArrivals, GapsAreExponentialWithTheRatesMean) {
  constexpr int kGaps = 10000;
  constexpr double kRate_per_s = 250;
  PoissonArrivals arrivals(3, kRate_per_s);
  double last_s = 0;
  int long_gaps = 0;
  for (int i = 0; i < kGaps; ++i) {
    const double at_s = arrivals.Next_s();
    ASSERT_GE(at_s, last_s);
    long_gaps += at_s - last_s > 1 / kRate_per_s;
    last_s = at_s;
  }
  EXPECT_NEAR(last_s, kGaps / kRate_per_s, 0.04 * kGaps / kRate_per_s);
  EXPECT_NEAR(long_gaps, kGaps / std::exp(1.0), 0.02 * kGaps);
}

TEST(PoissonArrivals, ASeedFixesThem) {
  PoissonArrivals one(7, 10);
  PoissonArrivals same(7, 10);
  PoissonArrivals other(8, 10);
  const double first_s = one.Next_s();
  EXPECT_EQ(first_s, same.Next_s());
  EXPECT_NE(first_s, other.Next_s());
}

}  // namespace
}  // namespace treeline::bench
