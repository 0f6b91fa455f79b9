#include "server/core/training/mean_shift.h"

#include <set>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::training {
namespace {

using testing::ElementsAre;

TEST(MeanShiftTest, ClustersFurtherApartThanTheBandwidthAreModes) {
  // Two near x = 0, three near x = 1, one at x = 5.
  const std::vector<Label> points = {{0, 0, 0},     {1, 0, 0},
                                     {1.02f, 0, 0}, {0.02f, 0, 0},
                                     {1, 0.01f, 0}, {5, 0, 0}};
  EXPECT_THAT(
      MeanShiftModes(points, 0.1, 32),
      ElementsAre(ElementsAre(1, 2, 4), ElementsAre(0, 3), ElementsAre(5)));
  EXPECT_THAT(MeanShiftModes(points, 0.1, 2),
              ElementsAre(ElementsAre(1, 2, 4), ElementsAre(0, 3)));
  EXPECT_THAT(MeanShiftModes(points, 20, 32),
              ElementsAre(ElementsAre(0, 1, 2, 3, 4, 5)));
}

TEST(MeanShiftTest, OneAndNoPoint) {
  EXPECT_TRUE(MeanShiftModes({}, 0.1, 32).empty());
  EXPECT_THAT(MeanShiftModes(std::vector<Label>{{1, 2, 3}}, 0.1, 32),
              ElementsAre(ElementsAre(0)));
}

TEST(MeanShiftTest, FindsTheClustersThatPointsWereDrawnFrom) {
  // Three clusters of 2 cm a component around corners 40 cm apart, more points
  // than shifts are started from. 10 cm are five standard deviations.
  base::Random random(1, 0);
  std::vector<Label> points;
  for (int i = 0; i < 900; ++i) {
    const double x = 0.4 * (i % 3);
    points.push_back({static_cast<float>(x + 0.02 * random.NextGaussian()),
                      static_cast<float>(0.02 * random.NextGaussian()),
                      static_cast<float>(0.02 * random.NextGaussian())});
  }
  const auto modes = MeanShiftModes(points, 0.1, 32);
  ASSERT_EQ(modes.size(), 3u);
  for (const std::vector<size_t>& mode : modes) {
    EXPECT_EQ(mode.size(), 300u);
    std::set<size_t> clusters;
    for (const size_t i : mode) clusters.insert(i % 3);
    EXPECT_EQ(clusters.size(), 1u);
  }
}

}  // namespace
}  // namespace treeline::training
