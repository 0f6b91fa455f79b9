#include "server/core/training/split_objective.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::training {
namespace {

template <typename Splitter>
ThresholdChoice Best(Splitter& splitter, std::span<const int16_t> values,
                     std::span<const Label> labels, int min_side) {
  splitter.SetLabels(labels);
  return splitter.Best(values, min_side);
}

TEST(BalanceObjectiveTest, ByHand) {
  const std::vector<int16_t> values = {-3, 0, 0, 5, 9, 20};
  EXPECT_DOUBLE_EQ(BalanceObjective(values, 0), 0);        // 3 and 3
  EXPECT_DOUBLE_EQ(BalanceObjective(values, -3), 4. / 6);  // 1 and 5
  EXPECT_DOUBLE_EQ(BalanceObjective(values, 5), 2. / 6);   // 4 and 2
  EXPECT_DOUBLE_EQ(BalanceObjective(values, 20), 1);       // 6 and 0
  EXPECT_DOUBLE_EQ(BalanceObjective(values, -100), 1);     // 0 and 6
  EXPECT_DOUBLE_EQ(BalanceObjective({}, 0), 1);
}

TEST(VarianceSplitterTest, SeparatesTwoClusters) {
  // Labels 0 and 10 m apart; the feature tells them apart at 7.
  const std::vector<int16_t> values = {7, 100, 3, 90, 5, 80};
  const std::vector<Label> labels = {{0, 0, 0},  {10, 0, 0}, {0, 0, 0},
                                     {10, 0, 0}, {0, 0, 0},  {10, 0, 0}};
  VarianceSplitter splitter;
  const ThresholdChoice choice = Best(splitter, values, labels, 1);
  EXPECT_EQ(choice.threshold, 7);
  // Six samples 5 m from their mean before, none after.
  EXPECT_DOUBLE_EQ(choice.gain, 6 * 25);
}

TEST(VarianceSplitterTest, KeepsEnoughOnBothSides) {
  // Best alone would cut off the first sample.
  const std::vector<int16_t> values = {-50, 1, 2, 3, 4, 5};
  const std::vector<Label> labels = {{9, 0, 0}, {0, 0, 0}, {0, 0, 0},
                                     {0, 0, 0}, {0, 0, 0}, {1, 0, 0}};
  VarianceSplitter splitter;
  EXPECT_EQ(Best(splitter, values, labels, 1).threshold, -50);
  EXPECT_EQ(Best(splitter, values, labels, 2).threshold, 1);
  EXPECT_EQ(Best(splitter, values, labels, 3).threshold, 2);
  EXPECT_LT(Best(splitter, values, labels, 4).gain, 0);
}

TEST(VarianceSplitterTest, EqualValuesCannotBeSplit) {
  const std::vector<int16_t> values = {4, 4, 4};
  const std::vector<Label> labels = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  VarianceSplitter splitter;
  EXPECT_LT(Best(splitter, values, labels, 1).gain, 0);
}

// Against Eq. 3.8 computed straight from its definition.
TEST(VarianceSplitterTest, FindsTheBestOfAllThresholds) {
  base::Random random(1, 0);
  VarianceSplitter splitter;
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<int16_t> values;
    std::vector<Label> labels;
    // Of the last thirty trials many values are equal.
    const int samples = trial % 2 == 0 ? 40 : 12;
    const uint32_t range = trial < 30 ? 511 : 9;
    for (int i = 0; i < samples; ++i) {
      values.push_back(static_cast<int16_t>(
          static_cast<int>(random.NextBelow(range)) - 255));
      labels.push_back({static_cast<float>(random.NextUniform(-2, 2)),
                        static_cast<float>(random.NextUniform(-2, 2)),
                        static_cast<float>(random.NextUniform(-2, 2))});
    }
    const auto scatter = [&](auto in) {
      double n = 0, x = 0, y = 0, z = 0, sum = 0;
      for (size_t i = 0; i < values.size(); ++i) {
        if (!in(values[i])) continue;
        n += 1;
        x += labels[i].x;
        y += labels[i].y;
        z += labels[i].z;
      }
      for (size_t i = 0; i < values.size(); ++i) {
        if (!in(values[i])) continue;
        sum += (labels[i].x - x / n) * (labels[i].x - x / n) +
               (labels[i].y - y / n) * (labels[i].y - y / n) +
               (labels[i].z - z / n) * (labels[i].z - z / n);
      }
      return sum;
    };
    const double all = scatter([](int) { return true; });
    double best = -1;
    for (int threshold : values) {
      const double gain = all - scatter([&](int v) { return v <= threshold; }) -
                          scatter([&](int v) { return v > threshold; });
      best = std::max(best, gain);
    }
    const ThresholdChoice choice = Best(splitter, values, labels, 1);
    EXPECT_NEAR(choice.gain, best, 1e-4 * best);
    const double achieved =
        all - scatter([&](int v) { return v <= choice.threshold; }) -
        scatter([&](int v) { return v > choice.threshold; });
    EXPECT_NEAR(achieved, best, 1e-4 * best);
  }
}

// n E(S) of Eq. 5.5 straight from its definition, with the splitter's noise.
double Entropy(const std::vector<Label>& labels) {
  const double n = static_cast<double>(labels.size());
  double mean[3] = {};
  double c[3][3] = {};
  const auto at = [](const Label& m, int i) {
    return static_cast<double>(i == 0 ? m.x : (i == 1 ? m.y : m.z));
  };
  for (const Label& m : labels) {
    for (int i = 0; i < 3; ++i) mean[i] += at(m, i) / n;
  }
  for (const Label& m : labels) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        c[i][j] += (at(m, i) - mean[i]) * (at(m, j) - mean[j]) / n;
      }
    }
  }
  for (auto i : {0, 1, 2}) {
    c[i][i] += EntropySplitter::kLabelSigma_m * EntropySplitter::kLabelSigma_m;
  }
  const double determinant = c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[2][1]) -
                             c[0][1] * (c[1][0] * c[2][2] - c[1][2] * c[2][0]) +
                             c[0][2] * (c[1][0] * c[2][1] - c[1][1] * c[2][0]);
  const double two_pi_e = 2 * std::numbers::pi * std::numbers::e;
  return n * 0.5 * std::log(std::pow(two_pi_e, 3) * determinant);
}

double EntropyGain(const std::vector<int16_t>& values,
                   const std::vector<Label>& labels, int threshold) {
  std::vector<Label> left;
  std::vector<Label> right;
  for (size_t i = 0; i < values.size(); ++i) {
    (values[i] <= threshold ? left : right).push_back(labels[i]);
  }
  return Entropy(labels) - Entropy(left) - Entropy(right);
}

TEST(EntropySplitterTest, FindsTheBestOfAllThresholds) {
  base::Random random(2, 0);
  EntropySplitter splitter;
  for (int trial = 0; trial < 30; ++trial) {
    std::vector<int16_t> values;
    std::vector<Label> labels;
    for (int i = 0; i < 60; ++i) {
      // At most kMaxThresholds + 1 different values: all are tried.
      const int value = static_cast<int>(random.NextBelow(25)) - 12;
      values.push_back(static_cast<int16_t>(10 * value));
      labels.push_back({static_cast<float>(random.NextUniform(-2, 2)),
                        static_cast<float>(random.NextUniform(-1, 1)),
                        static_cast<float>(0.1 * value)});
    }
    double best = -1;
    for (int threshold : values) {
      const auto left = std::ranges::count_if(
          values, [&](int value) { return value <= threshold; });
      if (left < 3 || left > 57) continue;
      best = std::max(best, EntropyGain(values, labels, threshold));
    }
    const ThresholdChoice choice = Best(splitter, values, labels, 3);
    // Sums are kept as floats.
    EXPECT_NEAR(choice.gain, best, 1e-3 * best);
    EXPECT_NEAR(EntropyGain(values, labels, choice.threshold), best,
                1e-3 * best);
  }
}

TEST(EntropySplitterTest, ManyThresholdsLoseLittle) {
  // 400 different values: 24 of the thresholds are tried. The labels are in
  // two clusters that the feature tells apart at about 0.
  base::Random random(3, 0);
  std::vector<int16_t> values;
  std::vector<Label> labels;
  for (int i = 0; i < 2000; ++i) {
    const int value = static_cast<int>(random.NextBelow(400)) - 200;
    values.push_back(static_cast<int16_t>(value));
    labels.push_back({static_cast<float>(random.NextUniform(0, 1)),
                      value > 0 ? 1.0f : 0.0f,
                      static_cast<float>(random.NextUniform(0, 1))});
  }
  EntropySplitter splitter;
  const ThresholdChoice choice = Best(splitter, values, labels, 2);
  // One in 25 of the samples lies between two thresholds that are tried.
  EXPECT_NEAR(choice.threshold, 0, 400. / 25);
  EXPECT_NEAR(choice.gain, EntropyGain(values, labels, choice.threshold),
              1e-3 * choice.gain);
}

TEST(EntropySplitterTest, PrefersWhatFlattensToWhatShortens) {
  // Samples fill two planes, 30 cm apart, each 2 m wide. Cutting the width in
  // half would reduce the variance most, telling the planes apart the entropy.
  base::Random random(4, 0);
  std::vector<int16_t> plane_feature;
  std::vector<int16_t> width_feature;
  std::vector<Label> labels;
  for (int i = 0; i < 400; ++i) {
    const bool upper = i % 2 == 0;
    const double x = random.NextUniform(-1, 1);
    labels.push_back({static_cast<float>(x),
                      static_cast<float>(random.NextUniform(-1, 1)),
                      upper ? 0.3f : 0.0f});
    plane_feature.push_back(upper ? 50 : -50);
    width_feature.push_back(x > 0 ? 50 : -50);
  }
  EntropySplitter entropy;
  EXPECT_GT(Best(entropy, plane_feature, labels, 2).gain,
            Best(entropy, width_feature, labels, 2).gain);
  VarianceSplitter variance;
  EXPECT_LT(Best(variance, plane_feature, labels, 2).gain,
            Best(variance, width_feature, labels, 2).gain);
}

TEST(EntropySplitterTest, EqualValuesAndSmallSidesCannotBeSplit) {
  const std::vector<Label> labels = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EntropySplitter splitter;
  EXPECT_LT(Best(splitter, std::vector<int16_t>{4, 4, 4}, labels, 1).gain, 0);
  EXPECT_LT(Best(splitter, std::vector<int16_t>{4, 5, 6}, labels, 2).gain, 0);
  // Nothing of the last calls is left over.
  const ThresholdChoice choice =
      Best(splitter, std::vector<int16_t>{4, 5, 5}, labels, 1);
  EXPECT_EQ(choice.threshold, 4);
  EXPECT_NEAR(choice.gain,
              EntropyGain(std::vector<int16_t>{4, 5, 5}, labels, 4), 1e-6);
}

}  // namespace
}  // namespace treeline::training
