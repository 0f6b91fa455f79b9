#include "client/bench/latency_histogram.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::bench {
namespace {

TEST(LatencyHistogram, NothingIsZero) {
  const LatencyHistogram histogram;
  EXPECT_EQ(histogram.count(), 0);
  EXPECT_EQ(histogram.mean_ms(), 0);
  EXPECT_EQ(histogram.Percentile_ms(50), 0);
}

TEST(LatencyHistogram, OneDurationIsEveryPercentile) {
  LatencyHistogram histogram;
  histogram.Add(12.3456);
  for (const double percent : {0.1, 50.0, 100.0}) {
    EXPECT_EQ(histogram.Percentile_ms(percent), 12.3456);
  }
  EXPECT_EQ(histogram.mean_ms(), 12.3456);
}

TEST(LatencyHistogram, ShortDurationsAreExactToTheMicrosecond) {
  LatencyHistogram histogram;
  for (int us = 1; us <= 100; ++us) histogram.Add(us * 1e-3);
  for (int percent = 1; percent <= 100; ++percent) {
    EXPECT_DOUBLE_EQ(histogram.Percentile_ms(percent), percent * 1e-3);
  }
}

// Nine decades of durations: each percentile lies where sorting them puts it.
TEST(LatencyHistogram, PercentilesAreAtMostASixtyFourthTooHigh) {
  base::Random random(1, 0);
  LatencyHistogram histogram;
  std::vector<double> sorted;
  for (int i = 0; i < 20000; ++i) {
    sorted.push_back(std::pow(10, random.NextUniform(-3, 6)));
    histogram.Add(sorted.back());
  }
  std::sort(sorted.begin(), sorted.end());
  for (const double percent :
       {0.01, 1.0, 10.0, 50.0, 90.0, 99.0, 99.9, 100.0}) {
    const double truth =
        sorted[static_cast<size_t>(std::ceil(percent / 100 * 20000)) - 1];
    const double found = histogram.Percentile_ms(percent);
    // Rounding to microseconds comes on top.
    EXPECT_GE(found, truth * (1 - 1e-12));
    EXPECT_LE(found, truth * (1 + 1.0 / 64) + 1.1e-3);
  }
}

TEST(LatencyHistogram, MergingIsCountingTogether) {
  base::Random random(2, 0);
  LatencyHistogram together;
  LatencyHistogram one;
  LatencyHistogram other;
  for (int i = 0; i < 1000; ++i) {
    const double ms = random.NextUniform(0, i % 2 == 0 ? 10 : 1000);
    together.Add(ms);
    (i % 2 == 0 ? one : other).Add(ms);
  }
  one.Merge(other);
  EXPECT_EQ(one.count(), together.count());
  EXPECT_EQ(one.max_ms(), together.max_ms());
  EXPECT_NEAR(one.mean_ms(), together.mean_ms(), 1e-9);
  for (const double percent : {1.0, 50.0, 99.0}) {
    EXPECT_EQ(one.Percentile_ms(percent), together.Percentile_ms(percent));
  }
}

TEST(LatencyHistogram, AbsurdDurationsAreKeptWithinBounds) {
  LatencyHistogram histogram;
  histogram.Add(-1);
  EXPECT_EQ(histogram.Percentile_ms(100), 0);
  histogram.Add(1e300);
  EXPECT_EQ(histogram.count(), 2);
  EXPECT_GT(histogram.Percentile_ms(100), 1e9);
}

TEST(LatencyHistogram, ComesBackFromItsParts) {
  LatencyHistogram histogram;
  for (const double ms : {0.0, 0.007, 3.0, 3.0, 12345.6}) histogram.Add(ms);
  const auto again = LatencyHistogram::FromParts(histogram.ToParts());
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->count(), 5);
  EXPECT_EQ(again->mean_ms(), histogram.mean_ms());
  EXPECT_EQ(again->max_ms(), 12345.6);
  for (const double percent : {1.0, 50.0, 99.0, 100.0}) {
    EXPECT_EQ(again->Percentile_ms(percent), histogram.Percentile_ms(percent));
  }
  EXPECT_FALSE(LatencyHistogram::FromParts({.buckets = {{1 << 20, 1}}}).ok());
  EXPECT_FALSE(LatencyHistogram::FromParts({.buckets = {{1, -1}}}).ok());
  EXPECT_FALSE(LatencyHistogram::FromParts({.sum_ms = HUGE_VAL}).ok());
}

}  // namespace
}  // namespace treeline::bench
