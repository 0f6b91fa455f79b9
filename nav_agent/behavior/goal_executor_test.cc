#include "nav_agent/behavior/goal_executor.h"

#include "nav_agent/behavior/testing_goal.h"

namespace treeline::behavior {
namespace {

class GoalExecutorTest : public GoalFixture {
 protected:
  core::VelocityCommand Step(double after_s = 0.025) {
    clock.Advance_s(after_s);
    return executor.Step(robot, Now());
  }
  void StartAndDrive(std::vector<core::LevelPose> poses) {
    executor.Start({.poses = std::move(poses)});
    Step();
    ASSERT_EQ(executor.phase(), GoalPhase::kDriving);
  }

  control::ControlPose robot = Robot(1, 2);
  GoalExecutor executor{OpenMap(), planner, controller, options, events};
};

TEST_F(GoalExecutorTest, WithoutAGoalItStands) {
  EXPECT_EQ(Step(), core::VelocityCommand{});
  EXPECT_EQ(executor.phase(), GoalPhase::kNone);
  EXPECT_FALSE(executor.status().has_value());
  EXPECT_EQ(executor.trouble(), core::NavigationCause::kNone);
}

TEST_F(GoalExecutorTest, PlansInTheStepAfterTheStart) {
  planner.holds = true;
  EXPECT_EQ(executor.Start({.poses = {PoseAtPoint(5, 2)}}), 1u);
  EXPECT_EQ(executor.phase(), GoalPhase::kToPlan);
  Step();
  EXPECT_EQ(executor.phase(), GoalPhase::kPlanning);
  planner.holds = false;
  // It sets off as soon as there is a path.
  EXPECT_EQ(Step().forward_mps, 0.5);
  EXPECT_EQ(executor.phase(), GoalPhase::kDriving);
  EXPECT_TRUE(executor.DrivesStraight());
  EXPECT_EQ(executor.route().path.size(), 2u);
}

TEST_F(GoalExecutorTest, AReachedGoalIsOver) {
  StartAndDrive({PoseAtPoint(5, 2)});
  robot = Robot(5, 2);
  controller.result.state = control::ControlState::kArrived;
  // The controller's command is of a path that there is no more.
  EXPECT_EQ(Step(), core::VelocityCommand{});
  EXPECT_EQ(executor.phase(), GoalPhase::kNone);
  EXPECT_EQ(executor.status()->state, GoalState::kSucceeded);
  EXPECT_EQ(executor.status()->next_pose, 1u);
  EXPECT_TRUE(controller.path.empty());
  EXPECT_TRUE(executor.route().path.empty());
}

TEST_F(GoalExecutorTest, GoesOnToTheNextPose) {
  StartAndDrive({PoseAtPoint(5, 2), PoseAtPoint(5, 6)});
  for (int i = 0; i < 4; ++i) Step();
  EXPECT_EQ(planner.requests.size(), 3u);
  robot = Robot(4.9, 2);
  Step();
  EXPECT_EQ(executor.phase(), GoalPhase::kDriving);
  EXPECT_EQ(executor.status()->next_pose, 1u);
  EXPECT_EQ(controller.path.back().map_from_base.translation.y, 6);
  EXPECT_EQ(executor.status()->replans, 0);
}

TEST_F(GoalExecutorTest, PlansOverWhatOfTheMapIsGone) {
  StartAndDrive({PoseAtPoint(5, 2)});
  EXPECT_EQ(planner.requests.back().freed, nullptr);
  controller.freed = std::make_shared<const traversability::FreedCells>();
  Step();
  EXPECT_TRUE(Said("map", "not there any more"));
  executor.Suspend();
  Step();
  EXPECT_EQ(planner.requests.back().freed, controller.freed);
  // More of it is told to the planner, not to people.
  controller.freed = std::make_shared<const traversability::FreedCells>();
  executor.Suspend();
  Step();
  EXPECT_EQ(planner.requests.back().freed, controller.freed);
  EXPECT_FALSE(Said("map", ""));
}

TEST_F(GoalExecutorTest, PlansTheNextLegIfItIsNotKnownYet) {
  StartAndDrive({PoseAtPoint(5, 2), PoseAtPoint(5, 6)});
  planner.holds = true;
  robot = Robot(4.9, 2);
  Step();
  EXPECT_EQ(executor.phase(), GoalPhase::kToPlan);
  EXPECT_FALSE(planner.IsBusy());
  planner.holds = false;
  Step();
  EXPECT_EQ(executor.phase(), GoalPhase::kDriving);
  // The first path of a leg is no new plan.
  EXPECT_EQ(executor.status()->replans, 0);
}

TEST_F(GoalExecutorTest, SuspendedItPlansAnew) {
  StartAndDrive({PoseAtPoint(5, 2)});
  executor.Suspend();
  EXPECT_EQ(executor.phase(), GoalPhase::kToPlan);
  EXPECT_TRUE(controller.path.empty());
  Step();
  EXPECT_EQ(executor.phase(), GoalPhase::kDriving);
  EXPECT_EQ(executor.status()->replans, 1);
  executor.End({.state = GoalState::kCancelled,
                .cause = core::NavigationCause::kCancelled,
                .why = "enough"});
  executor.Suspend();
  EXPECT_EQ(executor.phase(), GoalPhase::kNone);
}

TEST_F(GoalExecutorTest, MeasuresTheWay) {
  StartAndDrive({PoseAtPoint(5, 2)});
  robot = Robot(1.1, 2);
  Step();
  robot = Robot(1.2, 2);
  Step();
  EXPECT_DOUBLE_EQ(executor.status()->driven_m, 0.2);
}

TEST_F(GoalExecutorTest, RecoversThenFails) {
  // As long as the path: no other is better.
  controller.result.to_go_m = 4;
  controller.can_turn = false;
  controller.free_m = 0;
  StartAndDrive({PoseAtPoint(5, 2)});
  Step();
  Step(options.limits.progress_s);
  EXPECT_EQ(executor.phase(), GoalPhase::kRecovering);
  EXPECT_EQ(executor.trouble(), core::NavigationCause::kNoProgress);
  EXPECT_EQ(executor.status()->recoveries, 1);
  for (int i = 0; i < 100 && executor.is_active(); ++i) Step(30);
  EXPECT_EQ(executor.status()->state, GoalState::kFailed);
  EXPECT_EQ(executor.status()->cause, core::NavigationCause::kNoProgress);
  EXPECT_EQ(executor.status()->recoveries, options.limits.max_recoveries);
  EXPECT_TRUE(Said("goal", "10 recoveries did not help"));
  EXPECT_EQ(executor.trouble(), core::NavigationCause::kNone);
}

TEST_F(GoalExecutorTest, PlansWhenWhatItWaitsForIsGone) {
  AnswerFailure(core::NavigationCause::kPlanTimeout);
  AnswerFailure(core::NavigationCause::kPlanTimeout);
  executor.Start({.poses = {PoseAtPoint(5, 2)}});
  Step();
  ASSERT_EQ(executor.phase(), GoalPhase::kRecovering);
  executor.NoteWayIsFree();
  Step(1.5);
  EXPECT_EQ(executor.phase(), GoalPhase::kToPlan);
  Step();
  EXPECT_EQ(executor.phase(), GoalPhase::kDriving);
}

}  // namespace
}  // namespace treeline::behavior
