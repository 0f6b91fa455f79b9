#include "common/base/random.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::base {
namespace {

TEST(MixBits, MatchesPublishedSplitMix64Outputs) {
  // The first three outputs of SplitMix64 seeded with 0: its state advances by
  // the golden gamma before each draw.
  constexpr uint64_t kGamma = 0x9e3779b97f4a7c15u;
  EXPECT_EQ(MixBits(kGamma), 0xe220a8397b1dcdafu);
  EXPECT_EQ(MixBits(2 * kGamma), 0x6e789e6aa1b965f4u);
  EXPECT_EQ(MixBits(3 * kGamma), 0x06c45d188009454fu);
}

TEST(Random, IsAFunctionOfSeedStreamAndIndexOnly) {
  Random a(7, 3);
  std::vector<uint64_t> first;
  for (int i = 0; i < 100; ++i) first.push_back(a.NextBits());
  Random disturbance(7, 4);
  Random b(7, 3);
  for (int i = 0; i < 100; ++i) {
    disturbance.NextBits();
    EXPECT_EQ(b.NextBits(), first[static_cast<size_t>(i)]);
  }
}

TEST(Random, CanBeEvaluatedAtCompileTime) {
  constexpr uint64_t kBits = Random(1, 2).NextBits();
  Random random(1, 2);
  EXPECT_EQ(random.NextBits(), kBits);
}

TEST(Random, NeighbouringSeedsAndStreamsShareNoDraws) {
  std::set<uint64_t> seen;
  int draws = 0;
  for (uint64_t seed = 0; seed < 10; ++seed) {
    for (uint64_t stream = 0; stream < 10; ++stream) {
      Random random(seed, stream);
      for (int i = 0; i < 100; ++i, ++draws) seen.insert(random.NextBits());
    }
  }
  // Repeating one of 10^4 draws of 64 bits by chance: 3 in 10^12.
  EXPECT_EQ(static_cast<int>(seen.size()), draws);
}

TEST(Random, SeedAndStreamAreNotInterchangeable) {
  EXPECT_NE(Random(1, 2).NextBits(), Random(2, 1).NextBits());
}

TEST(Random, NextBelowIsUniform) {
  constexpr uint32_t kBound = 7;
  constexpr int kDraws = 70000;
  std::array<int, kBound> counts{};
  Random random(11, 0);
  for (int i = 0; i < kDraws; ++i) {
    const uint32_t value = random.NextBelow(kBound);
    ASSERT_LT(value, kBound);
    ++counts[value];
  }
  double chi_squared = 0;
  for (int count : counts) {
    const double expected = static_cast<double>(kDraws) / kBound;
    chi_squared += (count - expected) * (count - expected) / expected;
  }
  // 99.9 % quantile with 6 degrees of freedom.
  EXPECT_LT(chi_squared, 22.46);
}

TEST(Random, NextBelowOneIsZero) {
  Random random(5, 5);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(random.NextBelow(1), 0u);
}

TEST(Random, NextBelowReachesBothEndsOfALargeRange) {
  constexpr uint32_t kBound = 0xffffffffu;
  Random random(3, 9);
  uint32_t low = kBound;
  uint32_t high = 0;
  for (int i = 0; i < 10000; ++i) {
    const uint32_t value = random.NextBelow(kBound);
    low = std::min(low, value);
    high = std::max(high, value);
  }
  // The extremes of 10^4 draws lie within 0.2 % of the ends (p = 1 - e^-20).
  EXPECT_LT(low, kBound / 500);
  EXPECT_GT(high, kBound - kBound / 500);
}

TEST(Random, NextUnitHasTheMomentsOfTheUniformDistribution) {
  constexpr int kDraws = 100000;
  Random random(42, 1);
  double sum = 0;
  double sum_of_squares = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.NextUnit();
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    sum += u;
    sum_of_squares += u * u;
  }
  // Four standard errors: sqrt(1/12 / n) and sqrt(4/45 / n).
  EXPECT_NEAR(sum / kDraws, 0.5, 4 * 0.2887 / 316.2);
  EXPECT_NEAR(sum_of_squares / kDraws, 1.0 / 3, 4 * 0.2981 / 316.2);
}

TEST(Random, NextUniformStaysInItsRange) {
  Random random(42, 2);
  double sum = 0;
  for (int i = 0; i < 10000; ++i) {
    const double value = random.NextUniform(-3, 5);
    ASSERT_GE(value, -3);
    ASSERT_LT(value, 5);
    sum += value;
  }
  // Mean 1, standard deviation 8 / sqrt(12); four standard errors.
  EXPECT_NEAR(sum / 10000, 1, 4 * 2.31 / 100);
}

TEST(Random, NextGaussianHasTheMomentsOfTheStandardNormal) {
  constexpr int kDraws = 100000;
  Random random(42, 3);
  double sum = 0;
  double sum2 = 0;
  double sum4 = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double g = random.NextGaussian();
    ASSERT_TRUE(std::isfinite(g));
    sum += g;
    sum2 += g * g;
    sum4 += g * g * g * g;
  }
  // Four standard errors: the variances of g, g^2 and g^4 are 1, 2 and 96.
  EXPECT_NEAR(sum / kDraws, 0, 4 * 1.0 / 316.2);
  EXPECT_NEAR(sum2 / kDraws, 1, 4 * 1.414 / 316.2);
  EXPECT_NEAR(sum4 / kDraws, 3, 4 * 9.8 / 316.2);
}

TEST(Random, NeighbouringStreamsAreUncorrelated) {
  constexpr int kDraws = 100000;
  double sum = 0;
  for (uint64_t stream = 0; stream < kDraws; ++stream) {
    sum += (Random(1, stream).NextUnit() - 0.5) *
           (Random(1, stream + 1).NextUnit() - 0.5);
  }
  // The product has standard deviation 1/12; four standard errors.
  EXPECT_NEAR(sum / kDraws, 0, 4 * (1.0 / 12) / 316.2);
}

}  // namespace
}  // namespace treeline::base
