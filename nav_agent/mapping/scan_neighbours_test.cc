#include "nav_agent/mapping/scan_neighbours.h"

#include <algorithm>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::mapping {
namespace {

// 20 m there and, half a metre beside, back, a scan each half metre.
class ThereAndBack : public ::testing::Test {
 protected:
  ThereAndBack() {
    for (int i = 0; i <= 80; ++i) {
      const double x = i <= 40 ? 0.5 * i : 0.5 * (80 - i);
      poses_.push_back({{x, i <= 40 ? 0.0 : 0.5}, 0});
      way_m_.push_back(0.5 * i);
    }
  }
  ScanWay Way(bool same_floor) const {
    return {.map_from_scans = poses_,
            .way_m = way_m_,
            .may_be_compared = [same_floor](int a, int b) {
              return same_floor || (a <= 40) == (b <= 40);
            }};
  }
  static bool IsAcross(const ScanPair& pair) {
    return std::min(pair.a, pair.b) <= 40 && std::max(pair.a, pair.b) > 52;
  }

  std::vector<geometry::Rigid2> poses_;
  std::vector<double> way_m_;
};

TEST_F(ThereAndBack, ScansArePairedWithThoseBeforeAndWithTheOtherPass) {
  const std::vector<ScanPair> pairs = PairsThatOverlap(Way(true), 3);
  const auto has = [&](int a, int b) {
    return std::any_of(pairs.begin(), pairs.end(), [&](const ScanPair& pair) {
      return pair.a == a && pair.b == b;
    });
  };
  EXPECT_TRUE(has(69, 70));
  EXPECT_TRUE(has(58, 70));
  // Beside it on the way there, and four scans from that.
  EXPECT_TRUE(has(10, 70));
  EXPECT_TRUE(has(14, 70) || has(6, 70));
  EXPECT_FALSE(has(11, 70));
  EXPECT_FALSE(has(20, 70));
}

TEST_F(ThereAndBack, ScansOfAnotherFloorAreNotPaired) {
  for (const auto& pairs : {PairsThatOverlap(Way(false), 3),
                            PairsOfOtherPasses(Way(false), 3, 6, 1, 4)}) {
    EXPECT_EQ(std::count_if(pairs.begin(), pairs.end(), IsAcross), 0);
  }
  const auto pairs = PairsThatOverlap(Way(true), 3);
  EXPECT_GT(std::count_if(pairs.begin(), pairs.end(), IsAcross), 20);
}

// A ramp begins after scan 40.
TEST_F(ThereAndBack, ScansWhereARampBeginsArePairedAlongTheWayOnly) {
  ScanWay way = Way(false);
  way.untold_between = [](int, int) { return geometry::Vec2{1, 0}; };
  int across = 0;
  for (const ScanPair& pair : PairsThatOverlap(way, 3)) {
    const bool is_across = pair.a <= 40 && pair.b > 40;
    EXPECT_EQ(pair.untold.x, is_across ? 1 : 0);
    EXPECT_FALSE(IsAcross(pair));
    across += is_across ? 1 : 0;
  }
  EXPECT_GT(across, 10);
}

TEST_F(ThereAndBack, TheNearestOfOtherPassesComeFirst) {
  const auto pairs = PairsOfOtherPasses(Way(true), 3, 6, 1, 1);
  const auto of_70 = std::find_if(pairs.begin(), pairs.end(),
                                  [](const ScanPair& p) { return p.a == 70; });
  ASSERT_NE(of_70, pairs.end());
  EXPECT_EQ(of_70->b, 10);
}

TEST_F(ThereAndBack, TheNearestToAPlaceAreNoTwoInARow) {
  EXPECT_THAT(NearestScans(poses_, {{5, 0.1}, 0}, 2, 4),
              ::testing::UnorderedElementsAre(10, 70, 8, 12));
  // A turn of 3 radians is as far as 3 m.
  EXPECT_THAT(NearestScans(poses_, {{5, 0.1}, 3}, 2, 4), ::testing::IsEmpty());
}

}  // namespace
}  // namespace treeline::mapping
