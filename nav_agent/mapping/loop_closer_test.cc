#include "nav_agent/mapping/loop_closer.h"

#include <cmath>
#include <memory>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/mapping/testing_plan.h"

namespace treeline::mapping {
namespace {

constexpr double kStep_m = 0.5;
constexpr int kSteps = 36;

// A corridor with a pillar on either side every `period_m`: all that is seen
// at one place is seen a period further on, too.
std::vector<TestWall> Colonnade(double period_m) {
  std::vector<TestWall> walls = {{{-40, -1.5}, {60, -1.5}},
                                 {{-40, 1.5}, {60, 1.5}}};
  for (int i = -10; i < 20; ++i) {
    const double x = i * period_m;
    AddBox({x, -1.5}, {x + 0.3, -1.1}, &walls);
    AddBox({x + 0.5, 1.2}, {x + 0.7, 1.5}, &walls);
  }
  return walls;
}

// Along the corridor and, backwards, back again, by odometry that is longer by
// `stretch` on the way out.
LoopCloser Driven(const std::vector<TestWall>& walls, double stretch,
                  const LoopCloserOptions& options,
                  std::vector<geometry::Rigid2>& truth) {
  LoopCloser closer(options, {}, {});
  const core::RangeSensorInfo laser = TestLaser(4);
  for (int i = 0; i <= 2 * kSteps; ++i) {
    const int at = i <= kSteps ? i : 2 * kSteps - i;
    truth.push_back({{kStep_m * at, 0}, 0});
    NewKeyscan added;
    added.scan = std::make_shared<const ScanOutline>(MakeScanOutline(
        CastScan(walls, truth.back(), laser, 0.01, static_cast<uint64_t>(i)),
        laser, {}));
    const double way_m = i <= kSteps ? kStep_m * stretch : -kStep_m;
    added.previous_from_this = {{way_m, 0}, 0};
    // 5 cm and half a degree a step.
    added.covariance = {0.0025, 0, 0, 0, 1e-4, 0, 0, 0, 1e-4};
    closer.Add(added);
  }
  return closer;
}

int WrongLoops(const LoopCloser& closer,
               const std::vector<geometry::Rigid2>& truth) {
  int wrong = 0;
  for (const PoseConstraint& tie : closer.constraints()) {
    if (!tie.may_be_wrong) continue;
    const geometry::Rigid2 is = truth[static_cast<size_t>(tie.from)].Inverse() *
                                truth[static_cast<size_t>(tie.to)];
    const double off_m =
        geometry::Norm(is.translation - tie.from_from_to.translation);
    wrong += off_m > 0.3 ? 1 : 0;
  }
  return wrong;
}

TEST(LoopCloser, TiesTheWayBackToTheWayOut) {
  std::vector<TestWall> walls = Colonnade(30);
  AddBox({3, -1.5}, {4, -0.9}, &walls);
  AddBox({9, 1.1}, {9.4, 1.5}, &walls);
  AddBox({14, -1.5}, {14.2, -1.0}, &walls);
  std::vector<geometry::Rigid2> truth;
  const LoopCloser closer = Driven(walls, 1.02, {}, truth);
  EXPECT_GT(closer.statistics().accepted, 0);
  EXPECT_EQ(WrongLoops(closer, truth), 0);
}

// A period away all fits as well as where the robot is expected, which is a
// little off: nothing tells which is right. Who asks for no difference between
// the two takes the wrong one.
TEST(LoopCloser, PlacesThatAreAlikeAreNotTakenForEachOther) {
  LoopCloserOptions careless;
  careless.min_distinction = -1;
  for (const double period_m : {0.8, 1.2}) {
    for (const double stretch : {0.985, 0.99}) {
      std::vector<geometry::Rigid2> truth;
      EXPECT_EQ(
          WrongLoops(Driven(Colonnade(period_m), stretch, {}, truth), truth), 0)
          << period_m << ", " << stretch;
      truth.clear();
      EXPECT_GT(
          WrongLoops(Driven(Colonnade(period_m), stretch, careless, truth),
                     truth),
          0)
          << period_m << ", " << stretch;
    }
  }
}

// So many sides of a way round a hall, by odometry that is too long and turns:
// after four sides the robot is where the map says that it is not.
LoopCloser RoundHall(size_t sides, const LoopCloserOptions& options,
                     std::vector<geometry::Rigid2>& truth) {
  std::vector<TestWall> walls;
  AddBox({-1.5, -1.5}, {13.5, 9.5}, &walls);
  AddBox({1.5, 1.5}, {10.5, 6.5}, &walls);
  AddBox({4, -1.5}, {5, -1.0}, &walls);
  AddBox({13, 3}, {13.5, 4}, &walls);
  AddBox({7, 9.1}, {7.6, 9.5}, &walls);
  AddBox({-1.5, 5}, {-1.2, 6}, &walls);
  const std::vector<geometry::Vec2> corners = {
      {0, 0}, {12, 0}, {12, 8}, {0, 8}};
  truth.clear();
  for (size_t side = 0; side < sides; ++side) {
    const geometry::Vec2 from = corners[side % 4];
    const geometry::Vec2 way = corners[(side + 1) % 4] - from;
    const double yaw_rad = std::atan2(way.y, way.x);
    const int steps = static_cast<int>(geometry::Norm(way) / kStep_m);
    for (int i = 0; i < steps; ++i) {
      truth.push_back({from + (static_cast<double>(i) / steps) * way, yaw_rad});
    }
  }
  LoopCloser closer(options, {}, {});
  const core::RangeSensorInfo laser = TestLaser(6);
  for (size_t i = 0; i < truth.size(); ++i) {
    NewKeyscan added;
    added.scan = std::make_shared<const ScanOutline>(
        MakeScanOutline(CastScan(walls, truth[i], laser, 0.01, i), laser, {}));
    if (i > 0) {
      added.previous_from_this = truth[i - 1].Inverse() * truth[i];
      added.previous_from_this.translation =
          1.02 * added.previous_from_this.translation;
      added.previous_from_this.yaw_rad += 0.001;
    }
    added.covariance = {0.0025, 0, 0, 0, 1e-3, 0, 0, 0, 1e-4};
    closer.Add(added);
  }
  return closer;
}

double EndError_m(const LoopCloser& closer,
                  const std::vector<geometry::Rigid2>& truth) {
  return geometry::Norm(closer.Places().back().map_from_base.translation -
                        truth.back().translation);
}

TEST(LoopCloser, LoopsThatMoveTheRobotFarAreFollowedAndThenBelieved) {
  std::vector<geometry::Rigid2> truth;
  const LoopCloser closer = RoundHall(7, {.suspects = {.moved_m = 0.2}}, truth);
  EXPECT_GT(closer.statistics().suspected, 0);
  EXPECT_GT(closer.statistics().wide_accepted, 0);
  EXPECT_EQ(WrongLoops(closer, truth), 0);
  EXPECT_LT(EndError_m(closer, truth), 0.3);
}

TEST(LoopCloser, WhatIsFollowedIsDecidedAtTheEndAtTheLatest) {
  const LoopCloserOptions never = {
      .suspects = {.moved_m = 0.2, .follow_m = 100, .give_up_m = 1000}};
  std::vector<geometry::Rigid2> truth;
  LoopCloser closer = RoundHall(5, never, truth);
  ASSERT_GT(closer.statistics().suspected, 0);
  const double open_m = EndError_m(closer, truth);
  closer.Polish(1);
  EXPECT_LT(EndError_m(closer, truth), 0.5 * open_m);
}

}  // namespace
}  // namespace treeline::mapping
