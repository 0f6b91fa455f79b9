// The whole loop: a navigator drives a simulated robot to its goals.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/zones/zone_map.h"
#include "tests/robot/testing_mission.h"

namespace treeline {
namespace {

constexpr geometry::Vec2 kCounter = {9.2, 7.9};

double FromCounter_m(const TestMission& mission) {
  return Norm(mission.Truth().translation - kCounter);
}

bool Stands(TestMission& mission) {
  return std::abs(mission.simulator().state().forward_mps) < 1e-3;
}

// A crate, its measures times `scale`, in the way.
void AddCrate(TestMission& mission, const std::string& name, double x_m,
              double y_m, worlds::Float3 scale = {1, 1, 1},
              double height_m = 0) {
  const absl::Status added = mission.simulator().AddObstacle(
      name, "crate",
      {.position = {x_m, y_m}, .yaw_rad = 0, .height_m = height_m}, scale);
  ASSERT_TRUE(added.ok()) << added;
}

void Inject(TestMission& mission, simulator::FaultTarget target,
            simulator::FaultKind kind, double duration_s, double amount = 1) {
  const absl::Status injected = mission.simulator().Inject(
      {.target = target,
       .kind = kind,
       .duration = simulator::FromSeconds(duration_s),
       .amount = amount});
  ASSERT_TRUE(injected.ok()) << injected;
}

TEST(Mission, DrivesToAGoal) {
  TestMission mission({});
  mission.Send({mission.At(kCounter.x, kCounter.y)});
  const behavior::GoalStatus goal = mission.RunToEnd(40);
  EXPECT_EQ(goal.state, behavior::GoalState::kSucceeded) << mission.Story();
  EXPECT_LT(FromCounter_m(mission), 0.2);
  EXPECT_TRUE(Stands(mission));
  EXPECT_NEAR(goal.driven_m, 7.6, 0.5);
  EXPECT_EQ(goal.replans, 0);
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
  EXPECT_EQ(mission.navigator().Snapshot().missed_deadlines, 0);
}

// Thesis 6.6.1, the first scene.
TEST(Mission, DrivesUpTheSlopeToThePlatform) {
  TestMission mission({.start = {2.0, 0.9}});
  mission.Send({mission.Near(10.2, 1.6, 0, 0.51)});
  const behavior::GoalStatus goal = mission.RunToEnd(60);
  EXPECT_EQ(goal.state, behavior::GoalState::kSucceeded) << mission.Story();
  EXPECT_NEAR(mission.simulator().state().world_from_base.translation.z, 0.51,
              0.01);
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
}

TEST(Mission, DrivesThroughPosesWithoutStopping) {
  TestMission mission({});
  mission.Send({mission.At(4, 7.9, 2), mission.At(6.5, 7.7, -1),
                mission.At(kCounter.x, kCounter.y)});
  double slowest_mps = 1;
  const behavior::GoalStatus goal = mission.RunToEnd(40, [&] {
    const double x_m = mission.Truth().translation.x;
    if (x_m > 2.5 && x_m < 8) {
      slowest_mps =
          std::min(slowest_mps, mission.simulator().state().forward_mps);
    }
  });
  EXPECT_EQ(goal.state, behavior::GoalState::kSucceeded) << mission.Story();
  EXPECT_EQ(goal.next_pose, 3u);
  // Chairs stand near the way: it slows down for them, and does not stand.
  EXPECT_GT(slowest_mps, 0.08) << mission.Story();
}

zones::Zone Box(const std::string& name, zones::ZoneKind kind, double x0,
                double y0, double x1, double y1) {
  return {.name = name,
          .kind = kind,
          .level = 0,
          .corners_in_map = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}},
          .max_mps = 0.25};
}

std::shared_ptr<const zones::ZoneMap> SetZones(
    TestMission& mission, const std::vector<zones::Zone>& zones) {
  const auto made =
      zones::ZoneMap::Make(mission.map().traversable(), zones, {}, 0.6);
  EXPECT_TRUE(made.ok()) << made.status();
  const auto map = made.value_or(nullptr);
  EXPECT_TRUE(mission.navigator().SetZones(map).ok());
  return map;
}

// How much of the true footprint is in what is kept out of, in points of 5 cm;
// inset_m of its edge are left out: localization is off by that.
int PointsInside(const TestMission& mission, const zones::ZoneMap& zones,
                 double inset_m) {
  const core::RobotModel robot;
  int points = 0;
  for (double x = -robot.rear_m + inset_m; x <= robot.front_m - inset_m;
       x += 0.05) {
    for (double y = -robot.half_width_m + inset_m;
         y <= robot.half_width_m - inset_m; y += 0.05) {
      points += zones.IsKeptOut(0, mission.Truth() * geometry::Vec2{x, y});
    }
  }
  return points;
}

// It begins in a zone, has to go around another one and slowly through a third.
TEST(Mission, KeepsToItsZones) {
  constexpr double kEstimate_m = 0.08;
  TestMission mission({});
  const auto zones = SetZones(
      mission, {Box("start", zones::ZoneKind::kKeepOut, 0.6, 7.2, 2.4, 8.6),
                Box("aisle", zones::ZoneKind::kKeepOut, 5.2, 7.3, 6.6, 9.0),
                Box("counter", zones::ZoneKind::kSpeed, 7.4, 5.0, 8.4, 9.5)});
  ASSERT_GT(PointsInside(mission, *zones, 0), 0);
  mission.Send({mission.At(kCounter.x, kCounter.y)});
  bool is_out = false;
  int inside = 0;
  double fastest_mps = 0;
  const behavior::GoalStatus goal = mission.RunToEnd(90, [&] {
    const int now = PointsInside(mission, *zones, kEstimate_m);
    is_out = is_out || now == 0;
    if (is_out) inside = std::max(inside, now);
    const double x_m = mission.Truth().translation.x;
    if (x_m > 7.4 + kEstimate_m && x_m < 8.4 - kEstimate_m) {
      fastest_mps = std::max(fastest_mps,
                             std::abs(mission.simulator().state().forward_mps));
    }
  });
  EXPECT_EQ(goal.state, behavior::GoalState::kSucceeded) << mission.Story();
  EXPECT_TRUE(is_out);
  EXPECT_EQ(inside, 0) << mission.Story();
  EXPECT_GT(fastest_mps, 0.1);
  EXPECT_LT(fastest_mps, 0.25 + 0.03);
  EXPECT_LT(FromCounter_m(mission), 0.2);
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
}

// Zones that are drawn around a robot that drives, and over its goal.
TEST(Mission, ZonesThatAreDrawnOnTheWayHoldFromThenOn) {
  TestMission mission({});
  mission.Send({mission.At(kCounter.x, kCounter.y)});
  mission.Run(6);
  const geometry::Vec2 at = mission.Truth().translation;
  const auto around =
      SetZones(mission, {Box("here", zones::ZoneKind::kKeepOut, at.x - 0.6,
                             at.y - 0.6, at.x + 0.6, at.y + 0.6)});
  ASSERT_GT(PointsInside(mission, *around, 0), 0);
  ASSERT_TRUE(mission.RunUntil(
      [&] { return PointsInside(mission, *around, 0.05) == 0; }, 30))
      << mission.Story();
  EXPECT_EQ(mission.navigator().goal()->state, behavior::GoalState::kActive);
  SetZones(mission, {Box("goal", zones::ZoneKind::kKeepOut, kCounter.x - 1,
                         kCounter.y - 1, kCounter.x + 1, kCounter.y + 1)});
  const behavior::GoalStatus goal = mission.RunToEnd(10);
  EXPECT_EQ(goal.state, behavior::GoalState::kFailed) << mission.Story();
  EXPECT_EQ(goal.cause, core::NavigationCause::kZone);
  EXPECT_NE(goal.why.find("keep-out zone 'goal'"), std::string::npos)
      << goal.why;
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
}

// Thesis 6.6.1: the way is blocked, and another one is found.
TEST(Mission, GoesAnotherWayWhenTheAisleIsBlocked) {
  TestMission mission({.start = {3.0, 7.9}});
  mission.Send({mission.At(kCounter.x, kCounter.y)});
  mission.Run(3);
  AddCrate(mission, "a", 6.2, 7.0);
  AddCrate(mission, "b", 6.2, 7.7);
  AddCrate(mission, "c", 6.2, 8.4);
  const behavior::GoalStatus goal = mission.RunToEnd(120);
  EXPECT_EQ(goal.state, behavior::GoalState::kSucceeded) << mission.Story();
  EXPECT_LT(FromCounter_m(mission), 0.2);
  EXPECT_GE(goal.replans, 1);
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
}

TEST(Mission, WaitsWhereThereIsNoOtherWayAndGoesOnWhenItIsFree) {
  TestMission mission({.start = {2.0, 0.9}});
  AddCrate(mission, "crate", 5.5, 0.8, {1, 2.2f, 1}, 0.25);
  mission.Send({mission.Near(10.2, 1.6, 0, 0.51)});
  mission.Run(25);
  EXPECT_TRUE(mission.HasEvent("recovery", "wait")) << mission.Story();
  EXPECT_TRUE(mission.navigator().goal()->state == behavior::GoalState::kActive)
      << mission.Story();
  ASSERT_TRUE(mission.simulator().RemoveObstacle("crate").ok());
  const behavior::GoalStatus goal = mission.RunToEnd(90);
  EXPECT_EQ(goal.state, behavior::GoalState::kSucceeded) << mission.Story();
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
}

TEST(Mission, GivesUpWhenTheWayStaysBlockedAndTakesTheNextGoal) {
  TestMissionOptions options = {.start = {2.0, 0.9}};
  options.navigator.limits.max_recoveries = 3;
  TestMission mission(options);
  AddCrate(mission, "crate", 5.5, 0.8, {1, 2.2f, 1}, 0.25);
  mission.Send({mission.Near(10.2, 1.6, 0, 0.51)});
  const behavior::GoalStatus failed = mission.RunToEnd(120);
  EXPECT_EQ(failed.state, behavior::GoalState::kFailed) << mission.Story();
  EXPECT_EQ(failed.cause, core::NavigationCause::kBlocked);
  EXPECT_EQ(failed.recoveries, 3);
  mission.Send({mission.At(1.6, 3.8)});
  EXPECT_EQ(mission.RunToEnd(40).state, behavior::GoalState::kSucceeded)
      << mission.Story();
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
}

// Between tables, where it has no room to turn to that heading: it went to and
// fro there for two minutes, with 83 events of something in its way.
TEST(Mission, AGoalThatItCannotTakeEndsSoon) {
  TestMission mission({});
  mission.Send({mission.At(3.0, 2.0, 3.14)});
  const behavior::GoalStatus goal = mission.RunToEnd(90);
  EXPECT_EQ(goal.state, behavior::GoalState::kFailed) << mission.Story();
  EXPECT_EQ(goal.cause, core::NavigationCause::kGoalBlocked);
  EXPECT_TRUE(mission.HasEvent("goal", "there is no room to turn"))
      << mission.Story();
  EXPECT_LE(std::ranges::count(mission.events(), "blocked",
                               &behavior::NavigatorEvent::kind),
            6)
      << mission.Story();
  mission.Run(1);
  EXPECT_TRUE(Stands(mission));
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
}

// Something stands on the goal, and stays.
TEST(Mission, WaitsBesideAnOccupiedGoalAndSaysSo) {
  TestMission mission({.start = {3.0, 7.9}});
  AddCrate(mission, "crate", kCounter.x, kCounter.y);
  mission.Send({mission.At(kCounter.x, kCounter.y)});
  const behavior::GoalStatus goal = mission.RunToEnd(90);
  EXPECT_EQ(goal.state, behavior::GoalState::kFailed) << mission.Story();
  EXPECT_EQ(goal.cause, core::NavigationCause::kGoalBlocked) << mission.Story();
  EXPECT_TRUE(mission.HasEvent("goal", "the goal is occupied: stopped"))
      << mission.Story();
  EXPECT_TRUE(mission.HasEvent("recovery", "something stands on the goal"));
  EXPECT_FALSE(mission.HasEvent("recovery", "back up"));
  EXPECT_TRUE(Stands(mission));
  EXPECT_LT(FromCounter_m(mission), 2);
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
}

// Thesis 6.6.1 and Fig. 6.11: a person steps in front of the robot.
TEST(Mission, PassesAPersonWhoStepsInFront) {
  TestMission mission({});
  mission.Send({mission.At(kCounter.x, kCounter.y)});
  mission.RunUntil([&] { return mission.Truth().translation.x > 4; }, 20);
  // Walks in from the side at 1 m/s, 1.2 m ahead, and stays.
  AddCrate(mission, "person", 5.6, 9.0, {0.5f, 0.5f, 1.7f});
  double y_m = 9.0;
  const behavior::GoalStatus goal = mission.RunToEnd(90, [&] {
    if (y_m <= 7.95) return;
    y_m -= 0.025;
    ASSERT_TRUE(
        mission.simulator().MoveBody("person", {.position = {5.6, y_m}}).ok());
  });
  EXPECT_EQ(goal.state, behavior::GoalState::kSucceeded) << mission.Story();
  for (const simulator::SimEvent& mishap : mission.mishaps()) {
    EXPECT_FALSE(mishap.caused_by_robot) << mission.Story();
  }
}

struct FaultCase {
  const char* name;
  simulator::FaultTarget target;
  simulator::FaultKind kind;
  double amount;
  core::NavigationCause cause;
  // Until it stands (s).
  double within_s;
};

class MissionWithFault : public testing::TestWithParam<FaultCase> {};

TEST_P(MissionWithFault, StandsWithACauseAndGoesOn) {
  const FaultCase& fault = GetParam();
  TestMission mission({});
  mission.Send({mission.At(kCounter.x, kCounter.y)});
  mission.Run(4);
  ASSERT_FALSE(Stands(mission));
  Inject(mission, fault.target, fault.kind, 3, fault.amount);
  mission.Run(fault.within_s);
  EXPECT_TRUE(Stands(mission)) << mission.Story();
  EXPECT_EQ(mission.navigator().mode(), behavior::NavigatorMode::kSafeStop);
  const behavior::NavigatorSnapshot shot = mission.navigator().Snapshot();
  EXPECT_EQ(shot.cause, fault.cause) << mission.Story();
  EXPECT_FALSE(shot.cause_text.empty());
  mission.TakeTopSpeed_mps();
  mission.Run(2.9 - fault.within_s);
  EXPECT_LT(mission.TakeTopSpeed_mps(), 0.01) << mission.Story();
  const behavior::GoalStatus goal = mission.RunToEnd(40);
  EXPECT_EQ(goal.state, behavior::GoalState::kSucceeded) << mission.Story();
  EXPECT_LT(FromCounter_m(mission), 0.2);
  EXPECT_TRUE(mission.HasEvent("stop", core::NavigationCauseName(fault.cause)));
  EXPECT_TRUE(mission.HasEvent("resume", ""));
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
}

INSTANTIATE_TEST_SUITE_P(
    Faults, MissionWithFault,
    testing::Values(
        FaultCase{"LaserSilent", simulator::FaultTarget::kLaser,
                  simulator::FaultKind::kSilent, 1,
                  core::NavigationCause::kLaserLost, 1.2},
        FaultCase{"LaserFrozen", simulator::FaultTarget::kLaser,
                  simulator::FaultKind::kFrozen, 1,
                  core::NavigationCause::kLaserLost, 1.2},
        FaultCase{"LaserNaN", simulator::FaultTarget::kLaser,
                  simulator::FaultKind::kInvalid, 1,
                  core::NavigationCause::kLaserLost, 1.2},
        FaultCase{"LaserLate", simulator::FaultTarget::kLaser,
                  simulator::FaultKind::kDelay, 0.6,
                  core::NavigationCause::kLaserLost, 1.2},
        FaultCase{"LaserFuture", simulator::FaultTarget::kLaser,
                  simulator::FaultKind::kStampOffset, 0.6,
                  core::NavigationCause::kLaserLost, 1.2},
        FaultCase{"LaserPast", simulator::FaultTarget::kLaser,
                  simulator::FaultKind::kStampOffset, -0.6,
                  core::NavigationCause::kLaserLost, 1.2},
        FaultCase{"OdometrySilent", simulator::FaultTarget::kOdometry,
                  simulator::FaultKind::kSilent, 1,
                  core::NavigationCause::kOdometryLost, 1.2},
        FaultCase{"OdometryFrozen", simulator::FaultTarget::kOdometry,
                  simulator::FaultKind::kFrozen, 1,
                  core::NavigationCause::kOdometryLost, 1.5},
        FaultCase{"OdometryFuture", simulator::FaultTarget::kOdometry,
                  simulator::FaultKind::kStampOffset, 0.6,
                  core::NavigationCause::kOdometryLost, 1.2},
        FaultCase{"BaseRefuses", simulator::FaultTarget::kBase,
                  simulator::FaultKind::kSilent, 1,
                  core::NavigationCause::kBaseLost, 1.2}),
    [](const testing::TestParamInfo<FaultCase>& tested) {
      return tested.param.name;
    });

TEST(Mission, IsKidnappedAsksAndArrives) {
  TestMissionOptions options;
  options.has_server = true;
  TestMission mission(options);
  mission.Send({mission.At(kCounter.x, kCounter.y)});
  mission.Run(4);
  ASSERT_TRUE(
      mission.simulator().Kidnap({.position = {1.6, 3.8}, .yaw_rad = -1}).ok());
  const double kidnapped_s = simulator::Seconds(mission.simulator().now());
  ASSERT_TRUE(mission.RunUntil(
      [&] {
        return mission.navigator().mode() ==
               behavior::NavigatorMode::kRelocalizing;
      },
      15))
      << mission.Story();
  ASSERT_TRUE(mission.RunUntil(
      [&] {
        return mission.navigator().mode() == behavior::NavigatorMode::kDriving;
      },
      40))
      << mission.Story();
  // Back on its goal, where it truly is.
  EXPECT_LT(mission.Error_m(), 0.25) << mission.Story();
  EXPECT_LT(simulator::Seconds(mission.simulator().now()) - kidnapped_s, 20)
      << mission.Story();
  EXPECT_GE(mission.server().asked, 1);
  const behavior::GoalStatus goal = mission.RunToEnd(60);
  EXPECT_EQ(goal.state, behavior::GoalState::kSucceeded) << mission.Story();
  EXPECT_LT(FromCounter_m(mission), 0.25);
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
}

TEST(Mission, FindsItselfAtTheStart) {
  TestMissionOptions options;
  options.has_server = true;
  options.is_told_its_pose = false;
  options.navigator.finds_itself_at_start = true;
  TestMission mission(options);
  mission.Send({mission.At(4, 7.9)});
  const behavior::GoalStatus goal = mission.RunToEnd(60);
  EXPECT_EQ(goal.state, behavior::GoalState::kSucceeded) << mission.Story();
  EXPECT_LT(Norm(mission.Truth().translation - geometry::Vec2{4, 7.9}), 0.25);
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
}

TEST(Mission, StandsWhenItIsPausedAndGoesOnAfter) {
  TestMission mission({});
  mission.Send({mission.At(kCounter.x, kCounter.y)});
  mission.Run(4);
  mission.navigator().Pause();
  mission.Run(1.2);
  EXPECT_TRUE(Stands(mission));
  EXPECT_EQ(mission.navigator().mode(), behavior::NavigatorMode::kPaused);
  mission.navigator().Resume();
  EXPECT_EQ(mission.RunToEnd(40).state, behavior::GoalState::kSucceeded)
      << mission.Story();
}

TEST(Mission, ANewGoalReplacesTheOldOneWhileItDrives) {
  TestMission mission({});
  const uint64_t first = mission.Send({mission.At(kCounter.x, kCounter.y)});
  mission.Run(4);
  const uint64_t second = mission.Send({mission.At(1.6, 7.9)});
  EXPECT_GT(second, first);
  EXPECT_TRUE(mission.navigator().CancelGoal(first).code() ==
              absl::StatusCode::kNotFound);
  const behavior::GoalStatus goal = mission.RunToEnd(60);
  EXPECT_EQ(goal.id, second);
  EXPECT_EQ(goal.state, behavior::GoalState::kSucceeded) << mission.Story();
  EXPECT_TRUE(mission.HasEvent("goal", "preempted"));
}

TEST(Mission, TheSameSeedDrivesTheSameWay) {
  const auto drive = [] {
    TestMission mission({});
    mission.Send({mission.At(kCounter.x, kCounter.y)});
    mission.Run(6);
    return mission.Truth();
  };
  EXPECT_EQ(drive(), drive());
}

}  // namespace
}  // namespace treeline
