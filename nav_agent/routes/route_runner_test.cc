// A route above a navigator whose parts a test moves by hand.
#include "nav_agent/routes/route_runner.h"

#include <numbers>

#include "gmock/gmock.h"
#include "nav_agent/behavior/testing_navigator.h"

namespace treeline::routes {
namespace {

using behavior::GoalState;
using behavior::NavigatorMode;
using behavior::PoseAtPoint;
using ::testing::HasSubstr;

class RouteRunnerTest : public behavior::NavigatorFixture {
 protected:
  // A triangle; the second is waited at.
  static Route Triangle() {
    return {.name = "patrol",
            .waypoints = {{.position_in_map = {5, 2}},
                          {.position_in_map = {5, 5}, .wait_s = 3},
                          {.position_in_map = {2, 5}, .yaw_rad = 1}}};
  }
  void Start(Route route, size_t first = 0) {
    MakePlaced();
    const auto id = runner.Start(*navigator, std::move(route), first);
    ASSERT_TRUE(id.ok()) << id.status();
    RunRoute(0.1);
  }
  void RunRoute(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / kStep_s + 0.5); ++i) {
      Run(kStep_s);
      runner.Step(*navigator, clock.Now());
      for (behavior::NavigatorEvent& event : runner.TakeEvents()) {
        events.push_back(std::move(event));
      }
    }
  }
  // At the waypoint that it drives to.
  void Arrive() {
    ASSERT_EQ(status().state, RouteState::kDriving) << status().why;
    ASSERT_TRUE(runner.target().has_value());
    const uint64_t goal = status().goal_id;
    tracker->pose = runner.target();
    controller->result.state = control::ControlState::kArrived;
    for (int i = 0; i < 100 && status().state == RouteState::kDriving &&
                    status().goal_id == goal;
         ++i) {
      RunRoute(kStep_s);
    }
    controller->result.state = control::ControlState::kDriving;
  }
  // No way leads to the next plans' goals.
  void FailPlans(int plans) {
    for (int i = 0; i < plans; ++i) {
      planner->answers.emplace_back(behavior::FakePlannerWorker::Failure(
          core::NavigationCause::kGoalBlocked, "a wall"));
    }
  }
  const RouteStatus& status() { return *runner.status(); }
  geometry::Vec2 Target() {
    return runner.target()
        .value_or(core::LevelPose{})
        .map_from_base.translation;
  }
  double TargetYaw_rad() {
    return runner.target().value_or(core::LevelPose{}).map_from_base.yaw_rad;
  }

  RouteRunner runner;
};

TEST_F(RouteRunnerTest, DrivesFromWaypointToWaypointAndWaitsWhereItSaysSo) {
  Start(Triangle());
  EXPECT_EQ(status().state, RouteState::kDriving);
  EXPECT_EQ(Target(), (geometry::Vec2{5, 2}));
  // Where the way leads on.
  EXPECT_NEAR(TargetYaw_rad(), std::numbers::pi / 2, 1e-9);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  Arrive();
  EXPECT_EQ(status().progress.waypoint, 1u);
  EXPECT_EQ(Target(), (geometry::Vec2{5, 5}));
  Arrive();
  EXPECT_EQ(status().state, RouteState::kWaiting);
  RunRoute(2);
  EXPECT_EQ(status().state, RouteState::kWaiting);
  EXPECT_NEAR(status().waited_s, 2, 0.1);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  RunRoute(1.2);
  EXPECT_EQ(status().state, RouteState::kDriving);
  EXPECT_EQ(status().progress.waypoint, 2u);
  EXPECT_EQ(TargetYaw_rad(), 1);
  Arrive();
  EXPECT_EQ(status().state, RouteState::kSucceeded);
  EXPECT_EQ(status().progress.reached, 3);
  EXPECT_EQ(status().progress.missed, 0);
  EXPECT_FALSE(runner.IsOpen());
  RunRoute(5);
  EXPECT_EQ(mode(), NavigatorMode::kIdle);
  EXPECT_EQ(Count("route", "is over: 3 waypoints reached"), 1);
}

TEST_F(RouteRunnerTest, TheLastWithoutHeadingIsComeToAsTheWayCame) {
  Start({.waypoints = {{.position_in_map = {2, 6}}}});
  EXPECT_NEAR(TargetYaw_rad(), std::numbers::pi / 2, 1e-9);
}

TEST_F(RouteRunnerTest, ALoopBeginsAgain) {
  Route route = Triangle();
  route.is_loop = true;
  Start(route, 2);
  Arrive();
  EXPECT_EQ(status().progress.waypoint, 0u);
  EXPECT_EQ(status().progress.lap, 1);
  EXPECT_EQ(Target(), (geometry::Vec2{5, 2}));
  Arrive();
  EXPECT_EQ(status().progress.waypoint, 1u);
  EXPECT_TRUE(runner.IsUnderWay());
}

TEST_F(RouteRunnerTest, BeginsWithAnyWaypointThatThereIs) {
  MakePlaced();
  EXPECT_EQ(runner.Start(*navigator, Triangle(), 3).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_FALSE(runner.status().has_value());
}

TEST_F(RouteRunnerTest, AWaypointThatCannotBeReachedIsPassedOverAndListed) {
  Start(Triangle());
  Arrive();
  // However often it tries.
  FailPlans(100);
  for (int i = 0; i < 6000 && status().progress.missed == 0; ++i) {
    RunRoute(kStep_s);
  }
  planner->answers.clear();
  ASSERT_EQ(status().progress.missed, 1);
  const MissedWaypoint& missed = status().progress.last_missed.at(0);
  EXPECT_EQ(missed.waypoint, 1u);
  EXPECT_EQ(missed.cause, core::NavigationCause::kGoalBlocked);
  EXPECT_THAT(missed.why, HasSubstr("a wall"));
  EXPECT_EQ(status().progress.waypoint, 2u);
  RunRoute(0.1);
  Arrive();
  EXPECT_EQ(status().state, RouteState::kSucceeded);
  EXPECT_THAT(status().why, HasSubstr("2 waypoints reached, 1 missed"));
}

TEST_F(RouteRunnerTest, OrEndsTheRouteWhereThatIsWanted) {
  Route route = Triangle();
  route.when_missed = MissedPolicy::kStop;
  Start(route);
  FailPlans(100);
  for (int i = 0; i < 6000 && runner.IsOpen(); ++i) RunRoute(kStep_s);
  EXPECT_EQ(status().state, RouteState::kFailed);
  EXPECT_THAT(status().why, HasSubstr("waypoint 1 of 3 is missed"));
  RunRoute(1);
  EXPECT_EQ(mode(), NavigatorMode::kIdle);
}

TEST_F(RouteRunnerTest, AWaypointThatTheNavigatorRefusesIsMissedAtOnce) {
  Route route = Triangle();
  // The map has two levels.
  route.waypoints[1].level = 7;
  Start(route);
  Arrive();
  EXPECT_EQ(status().progress.missed, 1);
  EXPECT_EQ(status().progress.last_missed.at(0).waypoint, 1u);
  EXPECT_EQ(Target(), (geometry::Vec2{2, 5}));
}

TEST_F(RouteRunnerTest, ALoopOfWhichNothingCanBeReachedEnds) {
  Route route = Triangle();
  route.is_loop = true;
  for (Waypoint& waypoint : route.waypoints) waypoint.level = 7;
  MakePlaced();
  ASSERT_TRUE(runner.Start(*navigator, route, 0).ok());
  EXPECT_EQ(status().state, RouteState::kFailed);
  EXPECT_EQ(status().progress.missed, 3);
  route.is_loop = false;
  ASSERT_TRUE(runner.Start(*navigator, route, 0).ok());
  EXPECT_EQ(status().state, RouteState::kFailed);
  EXPECT_THAT(status().why, HasSubstr("no waypoint could be reached"));
}

// ---- stopped, paused, driven by hand ----

TEST_F(RouteRunnerTest, AStopHoldsItUntilSomebodyResumesIt) {
  Start(Triangle());
  Arrive();
  navigator->Stop("a child");
  RunRoute(1);
  EXPECT_EQ(status().state, RouteState::kHeld);
  EXPECT_THAT(status().why, HasSubstr("a child"));
  EXPECT_EQ(runner.Resume(*navigator).code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(runner.Start(*navigator, Triangle(), 0).status().code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(status().state, RouteState::kHeld);
  navigator->Release();
  RunRoute(5);
  // Nothing begins to move by a release.
  EXPECT_EQ(status().state, RouteState::kHeld);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  ASSERT_TRUE(runner.Resume(*navigator).ok());
  RunRoute(0.1);
  EXPECT_EQ(status().state, RouteState::kDriving);
  EXPECT_EQ(status().progress.waypoint, 1u);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
}

TEST_F(RouteRunnerTest, AStopWhileItWaitsHoldsItAndTheRestIsWaitedAfterwards) {
  Start(Triangle(), 1);
  Arrive();
  RunRoute(2);
  navigator->Stop("a child");
  RunRoute(10);
  EXPECT_EQ(status().state, RouteState::kHeld);
  navigator->Release();
  RunRoute(10);
  EXPECT_EQ(status().state, RouteState::kHeld);
  ASSERT_TRUE(runner.Resume(*navigator).ok());
  RunRoute(0.1);
  Arrive();
  EXPECT_EQ(status().state, RouteState::kWaiting);
  EXPECT_NEAR(status().waited_s, 2, 0.1);
  EXPECT_EQ(status().progress.reached, 1);
  RunRoute(1.2);
  EXPECT_EQ(status().progress.waypoint, 2u);
}

TEST_F(RouteRunnerTest, APauseIsNoTimeThatItWaits) {
  Start(Triangle(), 1);
  Arrive();
  RunRoute(1);
  navigator->Pause();
  RunRoute(10);
  EXPECT_EQ(status().state, RouteState::kWaiting);
  EXPECT_NEAR(status().waited_s, 1, 0.1);
  navigator->Resume();
  RunRoute(2.2);
  EXPECT_EQ(status().state, RouteState::kDriving);
}

TEST_F(RouteRunnerTest, DrivenByHandOnItsWayItGoesOnAfterResume) {
  Start(Triangle());
  ASSERT_TRUE(navigator->Drive({.forward_mps = 0.3, .yaw_rate_radps = 0}).ok());
  RunRoute(2);
  EXPECT_EQ(mode(), NavigatorMode::kPaused);
  ASSERT_TRUE(runner.Resume(*navigator).ok());
  RunRoute(0.1);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(status().progress.waypoint, 0u);
}

TEST_F(RouteRunnerTest, DrivenAwayWhileItWaitsItComesBackAfterResume) {
  Start(Triangle(), 1);
  Arrive();
  RunRoute(1);
  ASSERT_TRUE(navigator->Drive({.forward_mps = 0.3, .yaw_rate_radps = 0}).ok());
  tracker->pose = PoseAtPoint(7, 5);
  RunRoute(10);
  // It does not move by itself under the hands of somebody.
  EXPECT_EQ(mode(), NavigatorMode::kPaused);
  EXPECT_EQ(status().state, RouteState::kWaiting);
  navigator->Resume();
  RunRoute(0.1);
  EXPECT_EQ(status().state, RouteState::kDriving);
  EXPECT_EQ(status().progress.waypoint, 1u);
  EXPECT_EQ(Count("route", "it is elsewhere"), 1);
  Arrive();
  EXPECT_EQ(status().state, RouteState::kWaiting);
  EXPECT_NEAR(status().waited_s, 1, 0.1);
  EXPECT_EQ(status().progress.reached, 1);
}

TEST_F(RouteRunnerTest, KidnappedAndFoundItGoesOnToTheWaypointItWasAt) {
  Start(Triangle());
  Arrive();
  navigator->FindYourself();
  RunRoute(2);
  EXPECT_EQ(mode(), NavigatorMode::kLost);
  EXPECT_EQ(status().state, RouteState::kDriving);
  tracker->pose = PoseAtPoint(8, 8);
  lost->now_state = behavior::RelocalizationState::kIdle;
  RunRoute(0.2);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(status().progress.waypoint, 1u);
  EXPECT_EQ(planner->requests.back().goal.map_from_base.translation,
            (geometry::Vec2{5, 5}));
  EXPECT_EQ(planner->requests.back().start.map_from_base.translation,
            (geometry::Vec2{8, 8}));
}

TEST_F(RouteRunnerTest, KidnappedWhileItWaitsItComesBackAndWaitsTheRest) {
  Start(Triangle(), 1);
  Arrive();
  RunRoute(1);
  navigator->FindYourself();
  RunRoute(10);
  EXPECT_EQ(status().state, RouteState::kWaiting);
  EXPECT_NEAR(status().waited_s, 1, 0.1);
  tracker->pose = PoseAtPoint(8, 8);
  lost->now_state = behavior::RelocalizationState::kIdle;
  RunRoute(0.2);
  EXPECT_EQ(status().state, RouteState::kDriving);
  EXPECT_EQ(status().progress.waypoint, 1u);
  // Whether or not it knows that it was carried.
  Arrive();
  tracker->pose = PoseAtPoint(1, 1);
  RunRoute(1.1);
  EXPECT_EQ(status().state, RouteState::kDriving);
  EXPECT_EQ(status().progress.waypoint, 1u);
}

TEST_F(RouteRunnerTest, AGoalOfSomebodyElseHoldsIt) {
  Start(Triangle());
  Send({PoseAtPoint(8, 2)});
  RunRoute(0.1);
  EXPECT_EQ(status().state, RouteState::kHeld);
  EXPECT_THAT(status().why, HasSubstr("another goal"));
  EXPECT_EQ(Goal().state, GoalState::kActive);
  // Cancelling the route leaves that goal alone.
  ASSERT_TRUE(runner.Cancel(*navigator).ok());
  RunRoute(0.1);
  EXPECT_EQ(Goal().state, GoalState::kActive);
  EXPECT_EQ(status().state, RouteState::kCancelled);
}

TEST_F(RouteRunnerTest, ACancelEndsItWhereverItIs) {
  MakePlaced();
  EXPECT_EQ(runner.Cancel(*navigator).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(runner.Resume(*navigator).code(), absl::StatusCode::kNotFound);
  ASSERT_TRUE(runner.Start(*navigator, Triangle(), 0).ok());
  RunRoute(0.1);
  ASSERT_TRUE(runner.Cancel(*navigator).ok());
  RunRoute(1);
  EXPECT_EQ(mode(), NavigatorMode::kIdle);
  EXPECT_EQ(status().state, RouteState::kCancelled);
  // As does that of its goal.
  ASSERT_TRUE(runner.Start(*navigator, Triangle(), 0).ok());
  RunRoute(0.1);
  ASSERT_TRUE(navigator->CancelGoal(status().goal_id).ok());
  RunRoute(0.1);
  EXPECT_EQ(status().state, RouteState::kCancelled);
  EXPECT_EQ(mode(), NavigatorMode::kIdle);
}

TEST_F(RouteRunnerTest, AnotherRouteTakesItsPlace) {
  Start(Triangle());
  const uint64_t first = status().id;
  const auto second =
      runner.Start(*navigator, {.waypoints = {{.position_in_map = {9, 9}}}}, 0);
  ASSERT_TRUE(second.ok());
  EXPECT_GT(*second, first);
  RunRoute(0.1);
  EXPECT_EQ(Target(), (geometry::Vec2{9, 9}));
  EXPECT_EQ(Count("route", "another route took its place"), 1);
}

// ---- over a restart ----

TEST_F(RouteRunnerTest, AnOfferedRouteDrivesOnlyWhenItIsTakenUp) {
  MakePlaced();
  runner.Offer({.route = std::make_shared<const Route>(Triangle()),
                .waypoint = 2,
                .lap = 0,
                .reached = 1,
                .missed = 1},
               clock.Now());
  RunRoute(5);
  EXPECT_EQ(status().state, RouteState::kOffered);
  EXPECT_EQ(mode(), NavigatorMode::kIdle);
  EXPECT_FALSE(runner.IsHeld());
  ASSERT_TRUE(runner.Resume(*navigator).ok());
  RunRoute(0.1);
  EXPECT_EQ(Target(), (geometry::Vec2{2, 5}));
  Arrive();
  EXPECT_EQ(status().state, RouteState::kSucceeded);
  EXPECT_EQ(status().progress.reached, 2);
}

TEST_F(RouteRunnerTest, TheEndOfTheProgramIsNotTheEndOfTheRoute) {
  Start(Triangle());
  const uint64_t changes = runner.changes();
  runner.Halt();
  navigator->Halt();
  RunRoute(1);
  EXPECT_TRUE(runner.IsUnderWay());
  EXPECT_EQ(runner.changes(), changes);
}

}  // namespace
}  // namespace treeline::routes
