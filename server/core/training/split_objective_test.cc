#include "server/core/training/split_objective.h"

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline {
namespace {

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
  const ThresholdChoice choice = splitter.Best(values, labels, 1);
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
  EXPECT_EQ(splitter.Best(values, labels, 1).threshold, -50);
  EXPECT_EQ(splitter.Best(values, labels, 2).threshold, 1);
  EXPECT_EQ(splitter.Best(values, labels, 3).threshold, 2);
  EXPECT_LT(splitter.Best(values, labels, 4).gain, 0);
}

TEST(VarianceSplitterTest, EqualValuesCannotBeSplit) {
  const std::vector<int16_t> values = {4, 4, 4};
  const std::vector<Label> labels = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  VarianceSplitter splitter;
  EXPECT_LT(splitter.Best(values, labels, 1).gain, 0);
}

// Against Eq. 3.8 computed straight from its definition.
TEST(VarianceSplitterTest, FindsTheBestOfAllThresholds) {
  Random random(1, 0);
  VarianceSplitter splitter;
  for (int trial = 0; trial < 30; ++trial) {
    std::vector<int16_t> values;
    std::vector<Label> labels;
    for (int i = 0; i < 40; ++i) {
      values.push_back(
          static_cast<int16_t>(static_cast<int>(random.NextBelow(511)) - 255));
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
    const ThresholdChoice choice = splitter.Best(values, labels, 1);
    EXPECT_NEAR(choice.gain, best, 1e-4 * best);
    const double achieved =
        all - scatter([&](int v) { return v <= choice.threshold; }) -
        scatter([&](int v) { return v > choice.threshold; });
    EXPECT_NEAR(achieved, best, 1e-4 * best);
  }
}

}  // namespace
}  // namespace treeline
