#include "nav_agent/mapless/timed_way.h"

#include "gtest/gtest.h"
#include "nav_agent/mapless/testing_clutter.h"

namespace treeline::mapless {
namespace {

class TimedWayTest : public ::testing::Test {
 protected:
  TimedWayTest() { way_.Update(map_, {0, 0}, {20, 0}); }

  EvidenceGrid map_;
  WayField way_{BodyShape(SmallRobot(), 0.03)};
  TimedWay timed_{0.3, 2.0};
};

TEST_F(TimedWayTest, IsEmptyWhereNothingMoves) {
  timed_.Update(way_, {}, {0, 0});
  EXPECT_TRUE(timed_.empty());
  const Mover far = {.in_map = {40, 0}, .velocity_mps = {}, .radius_m = 0.5};
  timed_.Update(way_, {&far, 1}, {0, 0});
  EXPECT_TRUE(timed_.empty());
}

TEST_F(TimedWayTest, BehindWhatCrossesIsNearerThanBeforeIt) {
  // It is on the way in 1 s, and goes on to the left.
  const Mover mover = {
      .in_map = {2, -1.5}, .velocity_mps = {0, 1.5}, .radius_m = 0.5};
  timed_.Update(way_, {&mover, 1}, {0, 0});
  const double behind_m = timed_.ToGo({2, -1.5}, 1);
  const double before_m = timed_.ToGo({2, 1.0}, 1);
  const double in_it_m = timed_.ToGo({2, 0}, 1);
  EXPECT_LT(behind_m, before_m);
  EXPECT_GT(in_it_m, behind_m + 10);
  // Later it is gone.
  EXPECT_LT(timed_.ToGo({2, 0}, 2.5), in_it_m - 10);
}

TEST_F(TimedWayTest, ASlowRobotGoesBehindToo) {
  TimedWay slow(0.1, 0.3);
  const Mover mover = {
      .in_map = {0.3, -0.5}, .velocity_mps = {0, 0.5}, .radius_m = 0.1};
  slow.Update(way_, {&mover, 1}, {0, 0});
  EXPECT_LT(slow.ToGo({0.3, -0.4}, 1), slow.ToGo({0.3, 0.3}, 1));
  EXPECT_GT(slow.ToGo({0.3, 0}, 1), slow.ToGo({0.3, -0.4}, 1) + 1);
}

TEST_F(TimedWayTest, WaitingCostsWhatDrivingWouldHaveGained) {
  // Far aside, so that it threatens nobody.
  const Mover mover = {
      .in_map = {0, 9}, .velocity_mps = {0, 0.1}, .radius_m = 0.5};
  timed_.Update(way_, {&mover, 1}, {0, 0});
  // A second later at the same place: 2 m less can be driven in what is left.
  EXPECT_NEAR(timed_.ToGo({0, 0}, 3), timed_.ToGo({0, 0}, 2), 0.1);
  EXPECT_NEAR(timed_.ToGo({0, 0}, 2) - timed_.ToGo({2, 0}, 2), 2, 0.3);
}

TEST_F(TimedWayTest, WhoHasArrivedWaitsForNothing) {
  way_.Restart();
  way_.Update(map_, {0, 0}, {1, 0});
  const Mover mover = {
      .in_map = {0, 9}, .velocity_mps = {0, 0.1}, .radius_m = 0.5};
  timed_.Update(way_, {&mover, 1}, {0, 0});
  EXPECT_LT(timed_.ToGo({1, 0}, 0), 0.5);
  EXPECT_LT(timed_.ToGo({1, 0}, 1), timed_.ToGo({-1, 0}, 1) - 1.5);
}

TEST(Threat, GrowsAsTheGapShrinksAndSpreadsWithTime) {
  EXPECT_GT(ThreatRate_mps(-0.3, 0), ThreatRate_mps(-0.1, 0));
  EXPECT_GT(ThreatRate_mps(-0.1, 0), ThreatRate_mps(0.1, 0));
  EXPECT_GT(ThreatRate_mps(0.4, 2), ThreatRate_mps(0.4, 0.1));
  EXPECT_EQ(ThreatRate_mps(2, 0.1), 0);
}

}  // namespace
}  // namespace treeline::mapless
