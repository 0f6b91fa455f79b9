#include "nav_agent/drivers/stream/backoff.h"

#include <vector>

#include "gtest/gtest.h"

namespace treeline::stream {
namespace {

double Seconds(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

TEST(BackoffTest, DoublesUpToTheLongestWait) {
  Backoff backoff({.first_s = 0.1, .longest_s = 1.0, .jitter = 0}, 1);
  for (const double expected : {0.1, 0.2, 0.4, 0.8, 1.0, 1.0, 1.0}) {
    EXPECT_NEAR(Seconds(backoff.Next()), expected, 1e-6);
  }
  EXPECT_EQ(backoff.failures(), 7);
}

TEST(BackoffTest, BeginsAgainAfterASuccess) {
  Backoff backoff({.first_s = 0.1, .jitter = 0}, 1);
  backoff.Next();
  backoff.Next();
  backoff.Reset();
  EXPECT_NEAR(Seconds(backoff.Next()), 0.1, 1e-6);
}

TEST(BackoffTest, JitterStaysInItsBoundsAndFollowsTheSeed) {
  const BackoffOptions options = {
      .first_s = 1.0, .factor = 1.0, .longest_s = 1.0, .jitter = 0.2};
  Backoff first(options, 7);
  Backoff same(options, 7);
  Backoff other(options, 8);
  int different = 0;
  double sum = 0;
  for (int i = 0; i < 1000; ++i) {
    const double wait = Seconds(first.Next());
    EXPECT_GE(wait, 0.8 - 1e-6);
    EXPECT_LE(wait, 1.2);
    EXPECT_EQ(wait, Seconds(same.Next()));
    different += wait != Seconds(other.Next()) ? 1 : 0;
    sum += wait;
  }
  EXPECT_GT(different, 990);
  // Uniform on 0.4 s: a standard error of 0.0037 s.
  EXPECT_NEAR(sum / 1000, 1.0, 0.02);
}

TEST(BackoffTest, NeverOverflows) {
  Backoff backoff({.first_s = 0.1, .factor = 10, .longest_s = 2.0}, 1);
  for (int i = 0; i < 2000; ++i) {
    EXPECT_LE(Seconds(backoff.Next()), 2.4);
  }
}

TEST(BackoffTest, RefusesOptionsThatMakeNoSense) {
  EXPECT_TRUE(BackoffOptions().Validate().ok());
  EXPECT_FALSE(BackoffOptions{.first_s = 0}.Validate().ok());
  EXPECT_FALSE(BackoffOptions{.factor = 0.5}.Validate().ok());
  EXPECT_FALSE((BackoffOptions{.first_s = 2, .longest_s = 1}.Validate().ok()));
  EXPECT_FALSE(BackoffOptions{.jitter = 1}.Validate().ok());
}

}  // namespace
}  // namespace treeline::stream
