#include "server/access/rate_limiter.h"

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::access {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr base::MonotonicTime kStart{std::chrono::hours(5)};

TEST(RateBucket, LetsABurstInAndThenOneEachPeriod) {
  RateBucket bucket;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(bucket.Take(kStart, milliseconds(100), 3), std::nullopt);
  }
  EXPECT_EQ(bucket.Take(kStart, milliseconds(100), 3), milliseconds(100));
  EXPECT_EQ(bucket.Take(kStart + milliseconds(40), milliseconds(100), 3),
            milliseconds(60));
  EXPECT_EQ(bucket.Take(kStart + milliseconds(100), milliseconds(100), 3),
            std::nullopt);
  EXPECT_EQ(bucket.Take(kStart + milliseconds(100), milliseconds(100), 3),
            milliseconds(100));
}

TEST(RateBucket, IsFullAgainAfterAPauseAndNoFuller) {
  RateBucket bucket;
  while (!bucket.Take(kStart, milliseconds(10), 5)) {
  }
  const base::MonotonicTime later = kStart + std::chrono::hours(1);
  int taken = 0;
  while (!bucket.Take(later, milliseconds(10), 5)) ++taken;
  EXPECT_EQ(taken, 5);
}

// Arrivals at random; the promises hold for every window between two of them.
TEST(RateBucket, NeverLetsInMoreThanBurstAndRateAllowAndNeverNeedlesslyLess) {
  for (uint64_t seed = 0; seed < 40; ++seed) {
    base::Random random(seed, 0);
    const nanoseconds period(1 + random.NextBelow(1000));
    const int64_t burst = 1 + random.NextBelow(8);
    RateBucket bucket;
    std::vector<base::MonotonicTime> admitted;
    base::MonotonicTime now = kStart;
    for (int i = 0; i < 400; ++i) {
      now += nanoseconds(
          random.NextBelow(static_cast<uint32_t>(2 * period.count()) / 3 + 1));
      const auto wait = bucket.Take(now, period, burst);
      if (!wait) {
        admitted.push_back(now);
        continue;
      }
      // Just before the time it names it is still refused; then it is not.
      RateBucket copy = bucket;
      ASSERT_NE(copy.Take(now + *wait - nanoseconds(1), period, burst),
                std::nullopt);
      ASSERT_EQ(copy.Take(now + *wait, period, burst), std::nullopt);
    }
    for (size_t i = 0; i < admitted.size(); ++i) {
      for (size_t j = i; j < admitted.size(); ++j) {
        const int64_t most = burst + (admitted[j] - admitted[i]) / period;
        ASSERT_LE(static_cast<int64_t>(j - i + 1), most) << "seed " << seed;
      }
    }
    ASSERT_GT(admitted.size(), static_cast<size_t>(burst));
  }
}

TEST(RateBucket, GivesTheWholeRateToWhoAsksAllTheTime) {
  RateBucket bucket;
  int taken = 0;
  for (int i = 0; i < 10000; ++i) {
    if (!bucket.Take(kStart + milliseconds(i), milliseconds(7), 1)) ++taken;
  }
  EXPECT_EQ(taken, (10000 + 6) / 7);
}

TEST(RateLimiter, CountsEachCallerForItself) {
  RateLimiter limiter(100);
  EXPECT_EQ(limiter.Take("a", kStart, 1, 1), std::nullopt);
  EXPECT_EQ(limiter.Take("a", kStart, 1, 1), std::chrono::seconds(1));
  EXPECT_EQ(limiter.Take("b", kStart, 1, 1), std::nullopt);
}

TEST(RateLimiter, RemembersABoundedNumberOfForgedCallers) {
  RateLimiter limiter(100);
  for (int i = 0; i < 10000; ++i) {
    limiter.Take(absl::StrCat("forged-", i), kStart, 1, 1);
    limiter.Take("steady", kStart, 1, 1);
  }
  EXPECT_EQ(limiter.size(), 100u);
  // The one that asks all the time was not forgotten.
  EXPECT_NE(limiter.Take("steady", kStart, 1, 1), std::nullopt);
}

TEST(RateLimiter, TakesAnyRateAndBurst) {
  RateLimiter limiter(10);
  for (const double rate : {0.0, 1e-300, 1e-6, 1e9, 1e300}) {
    for (const int64_t burst : {int64_t{-1}, int64_t{1}, INT64_MAX}) {
      const std::string caller = absl::StrCat(rate, " ", burst);
      EXPECT_EQ(limiter.Take(caller, kStart, rate, burst), std::nullopt);
      limiter.Take(caller, kStart, rate, burst);
    }
  }
}

}  // namespace
}  // namespace treeline::access
