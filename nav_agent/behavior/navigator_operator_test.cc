// A navigator that people stop, release, and drive by hand.
#include <limits>

#include "gmock/gmock.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/behavior/testing_navigator.h"

namespace treeline::behavior {
namespace {

using ::testing::HasSubstr;
using NavigatorOperatorTest = NavigatorFixture;

constexpr core::VelocityCommand kAhead = {.forward_mps = 0.3,
                                          .yaw_rate_radps = 0.2};

TEST_F(NavigatorOperatorTest, AStopEndsTheGoalInTheNextStepAndHolds) {
  MakePlaced();
  Send({PoseAtPoint(5, 2)});
  Run(0.05);
  ASSERT_EQ(Last().forward_mps, 0.5);
  navigator->Stop("a child");
  Run(kStep_s);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  EXPECT_GT(base.stops, 0);
  EXPECT_EQ(mode(), NavigatorMode::kStopped);
  EXPECT_EQ(Goal().state, GoalState::kCancelled);
  EXPECT_EQ(Goal().cause, core::NavigationCause::kStopped);
  EXPECT_THAT(Goal().why, HasSubstr("a child"));
  const NavigatorSnapshot shot = navigator->Snapshot();
  ASSERT_TRUE(shot.stop.has_value());
  EXPECT_EQ(shot.stop->why, "a child");
  EXPECT_EQ(shot.cause, core::NavigationCause::kStopped);
  // Neither time nor Resume nor a new pose ends it.
  navigator->Resume();
  ASSERT_TRUE(navigator->SetPose(PoseAtPoint(3, 2), {}).ok());
  Run(5);
  EXPECT_EQ(mode(), NavigatorMode::kStopped);
  EXPECT_EQ(Count("stop", "a child"), 1);
}

TEST_F(NavigatorOperatorTest, WhileItHoldsEveryWayToDriveIsRefused) {
  MakePlaced();
  navigator->Stop("a child");
  const absl::Status goal =
      navigator->SetGoal({.poses = {PoseAtPoint(5, 2)}}).status();
  EXPECT_EQ(goal.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(goal.message()), HasSubstr("a child"));
  const absl::Status drive = navigator->Drive(kAhead);
  EXPECT_EQ(drive.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(drive.message()), HasSubstr("release"));
  base.commands.clear();
  Run(1);
  for (const core::VelocityCommand& command : base.commands) {
    EXPECT_EQ(command, core::VelocityCommand{});
  }
}

TEST_F(NavigatorOperatorTest, ASearchForItsPlaceStandsAndWaitsAfterwards) {
  MakePlaced();
  navigator->FindYourself();
  lost->now_state = RelocalizationState::kTurning;
  lost->wanted = kAhead;
  Run(0.1);
  ASSERT_EQ(Last(), kAhead);
  navigator->Stop("a child");
  Run(kStep_s);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  navigator->Release();
  Run(1);
  EXPECT_EQ(mode(), NavigatorMode::kPaused);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  navigator->Resume();
  Run(0.1);
  EXPECT_EQ(Last(), kAhead);
}

TEST_F(NavigatorOperatorTest, AReleaseStartsNothingAndLetsGoalsBeTaken) {
  MakePlaced();
  Send({PoseAtPoint(5, 2)});
  Run(0.05);
  navigator->Stop("a child");
  Run(0.1);
  navigator->Release();
  Run(1);
  EXPECT_EQ(mode(), NavigatorMode::kIdle);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  EXPECT_EQ(Count("release", "a child"), 1);
  Send({PoseAtPoint(5, 2)});
  Run(0.05);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
}

TEST_F(NavigatorOperatorTest, StoppedBeforeItBeginsItDoesNotLookForItself) {
  NavigatorOptions options;
  options.finds_itself_at_start = true;
  Make(options);
  navigator->Stop("stopped before the restart");
  Run(1);
  EXPECT_TRUE(lost->begun.empty());
  navigator->Release();
  Run(0.1);
  EXPECT_EQ(mode(), NavigatorMode::kPaused);
  EXPECT_TRUE(lost->begun.empty());
  navigator->Resume();
  Run(0.1);
  EXPECT_EQ(lost->begun.size(), 1u);
}

TEST_F(NavigatorOperatorTest, IsDrivenByHandAndStandsWhenNobodySpeaks) {
  MakePlaced();
  ASSERT_TRUE(navigator->Drive(kAhead).ok());
  Run(0.25);
  EXPECT_EQ(mode(), NavigatorMode::kManual);
  EXPECT_EQ(Last(), kAhead);
  Run(0.1);
  EXPECT_EQ(mode(), NavigatorMode::kIdle);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(navigator->Drive({.forward_mps = nan, .yaw_rate_radps = 0}).code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(NavigatorOperatorTest, ByHandGoesThroughTheCollisionGuard) {
  MakePlaced();
  controller->guard_stops = true;
  ASSERT_TRUE(navigator->Drive(kAhead).ok());
  Run(0.1);
  EXPECT_EQ(mode(), NavigatorMode::kManual);
  EXPECT_EQ(Last(), core::VelocityCommand{});
}

TEST_F(NavigatorOperatorTest, AGoalWaitsForResumeAfterItWasDrivenByHand) {
  MakePlaced();
  Send({PoseAtPoint(5, 2)});
  Run(0.05);
  ASSERT_TRUE(navigator->Drive(kAhead).ok());
  Run(1);
  EXPECT_EQ(mode(), NavigatorMode::kPaused);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  navigator->Resume();
  Run(0.1);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
}

TEST_F(NavigatorOperatorTest, ARobotWithoutLaserIsNotDrivenByHand) {
  MakePlaced();
  ASSERT_TRUE(navigator->Drive(kAhead).ok());
  Run(0.1);
  laser_runs = false;
  Run(0.5);
  EXPECT_EQ(mode(), NavigatorMode::kSafeStop);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  const absl::Status drive = navigator->Drive(kAhead);
  EXPECT_EQ(drive.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(drive.message()), HasSubstr("laser"));
}

TEST_F(NavigatorOperatorTest, ASteeredStepIsOneAndItsGoalWaits) {
  MakePlaced();
  Send({PoseAtPoint(5, 2)});
  Run(0.1);
  ASSERT_EQ(Last().forward_mps, 0.5);
  const SteeringCommand steering = {
      .wanted = {.forward_mps = -0.1, .yaw_rate_radps = 0},
      .docked = PoseAtPoint(2.2, 2),
      .what = "drives out"};
  ASSERT_TRUE(navigator->Steer(steering).ok());
  Run(kStep_s);
  EXPECT_EQ(Last().forward_mps, -0.1);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(navigator->Snapshot().cause_text, "drives out");
  EXPECT_TRUE(controller->path.empty());
  EXPECT_EQ(Goal().state, GoalState::kActive);
  // Nobody says it again: the goal is planned anew.
  Run(0.1);
  EXPECT_EQ(Last().forward_mps, 0.5);
  EXPECT_FALSE(controller->path.empty());
}

TEST_F(NavigatorOperatorTest, SteeringComesAfterPausesHandsAndStops) {
  MakePlaced();
  const SteeringCommand steering = {
      .wanted = {.forward_mps = 0.1, .yaw_rate_radps = 0},
      .docked = PoseAtPoint(2.2, 2),
      .what = ""};
  navigator->Pause();
  ASSERT_TRUE(navigator->Steer(steering).ok());
  Run(kStep_s);
  EXPECT_EQ(mode(), NavigatorMode::kPaused);
  navigator->Resume();
  // What was said before is not kept.
  Run(kStep_s);
  EXPECT_EQ(mode(), NavigatorMode::kIdle);
  ASSERT_TRUE(navigator->Drive(kAhead).ok());
  ASSERT_TRUE(navigator->Steer(steering).ok());
  Run(kStep_s);
  EXPECT_EQ(mode(), NavigatorMode::kManual);
  SteeringCommand bad = steering;
  bad.wanted.yaw_rate_radps = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(navigator->Steer(bad).code(), absl::StatusCode::kInvalidArgument);
  bad = steering;
  bad.docked.place.level = 7;
  EXPECT_EQ(navigator->Steer(bad).code(), absl::StatusCode::kInvalidArgument);
  ASSERT_TRUE(navigator->Steer(steering).ok());
  navigator->Stop("a child");
  Run(kStep_s);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  EXPECT_EQ(navigator->Steer(steering).code(),
            absl::StatusCode::kFailedPrecondition);
  navigator->Release();
  Run(kStep_s);
  EXPECT_EQ(Last(), core::VelocityCommand{});
}

}  // namespace
}  // namespace treeline::behavior
