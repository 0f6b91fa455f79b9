#include "nav_agent/planning/path_smoother.h"

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "nav_agent/planning/guide.h"
#include "nav_agent/planning/testing_maps.h"

namespace treeline::planning {
namespace {

ConfigurationSpace SpaceOf(const std::vector<std::string>& rows, int scale) {
  return {std::make_shared<const GroundIndex>(DrawnMap(rows, scale)),
          Footprint::Of(core::RobotModel(), 0.03),
          {}};
}

TEST(FollowGuideTest, TakesTheMiddleOfAGapThatLiesBetweenTheCells) {
  // 0.70 m wide, for 0.68 m of footprint, and 1 m long; its middle is the side
  // of two rows of cells.
  std::vector<std::string> rows = RoomRows(160, 80);
  Fill(rows, 70, 90, 1, 79, '#');
  Fill(rows, 70, 90, 30, 44, '.');
  const ConfigurationSpace space = SpaceOf(rows, 1);
  const Polyline guide = {
      {{1, 1.825}, 0}, {{3, 1.825}, 0}, {{5, 1.825}, 0}, {{7, 1.825}, 0}};
  EXPECT_FALSE(space.Drive(guide.front(), guide.back().at).has_value());
  const PulledWay pulled =
      FollowGuide(space, 0, 0, guide, 0.15,
                  [](const Stand&, const Stand&) { return Polyline(); });
  EXPECT_TRUE(pulled.is_whole);
  EXPECT_TRUE(CanBeDriven(space, 0, 0, pulled.way));
}

TEST(PathSmootherTest, GetsCheaperAndNoLongerThanItMay) {
  std::vector<std::string> rows = RoomRows(80, 60);
  Fill(rows, 38, 42, 30, 59, '#');
  const ConfigurationSpace space = SpaceOf(rows, 2);
  const auto smoothed = [](const ConfigurationSpace& prices,
                           const Polyline& way, double max_m) {
    PathSmoother smoother(prices, 0, 0, way, max_m);
    for (uint64_t i = 0; i < 3000; ++i) {
      base::Random random(7, i);
      smoother.Try(random);
    }
    return smoother;
  };
  constexpr double kAny_m = std::numeric_limits<double>::infinity();
  const Polyline way = {
      {{1, 4}, 0}, {{3.5, 2.4}, 0}, {{4.5, 2.4}, 0}, {{7, 4}, 0}};
  const Polyline tight =
      smoothed(space.WithPrices({.near = 0, .slope = 0}), way, kAny_m).way();
  const double max_m = 1.005 * PathLength_m(tight);
  const PathSmoother bound = smoothed(space, tight, max_m);
  const PathSmoother free = smoothed(space, tight, kAny_m);
  EXPECT_LE(bound.length_m(), max_m);
  EXPECT_GT(free.length_m(), max_m);
  EXPECT_LT(bound.cost_m(), PathCost_m(space, 0, 0, tight) - 0.01);
  EXPECT_LT(free.cost_m(), bound.cost_m());
}

}  // namespace
}  // namespace treeline::planning
