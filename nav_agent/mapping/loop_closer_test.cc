#include "nav_agent/mapping/loop_closer.h"

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

}  // namespace
}  // namespace treeline::mapping
