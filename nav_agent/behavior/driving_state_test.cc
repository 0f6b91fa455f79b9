#include "nav_agent/behavior/driving_state.h"

#include <variant>
#include <vector>

#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/testing_goal.h"

namespace treeline::behavior {
namespace {

class DrivingStateTest : public GoalFixture {
 protected:
  DrivingState Drive(const PlannedPath& path) {
    return DrivingState(path, "a way", goal, tools);
  }
  DrivingState Drive() {
    return Drive(Straight(PoseAtPoint(1, 2), PoseAtPoint(5, 2)));
  }
  DrivingState::Result Step(DrivingState& driving, double after_s = 0) {
    clock.Advance_s(after_s);
    return driving.Step(robot, goal, tools, Now());
  }
  template <typename Outcome>
  static bool Is(const DrivingState::Result& result) {
    return std::holds_alternative<Outcome>(result.outcome);
  }

  control::ControlPose robot = Robot(1, 2);
};

TEST_F(DrivingStateTest, FollowsItsPath) {
  DrivingState driving = Drive();
  EXPECT_EQ(controller.path.size(), 2u);
  EXPECT_EQ(tools.route.path.size(), 2u);
  EXPECT_EQ(goal.status.to_go_m, 4);
  EXPECT_TRUE(Said("plan", "a way of 4.0 m to (5.00, 2.00) on level 0"));
  EXPECT_FALSE(driving.DrivesStraight());
  const DrivingState::Result result = Step(driving);
  EXPECT_TRUE(Is<DrivingState::GoesOn>(result));
  EXPECT_EQ(result.command.forward_mps, 0.5);
  EXPECT_EQ(goal.status.to_go_m, controller.result.to_go_m);
  EXPECT_TRUE(driving.DrivesStraight());
}

TEST_F(DrivingStateTest, TakesAPathThatIsNotablyShorter) {
  PlannedPath path = Straight(PoseAtPoint(1, 2), PoseAtPoint(5, 2));
  path.result.length_m = 6;
  path.may_be_better = true;
  DrivingState driving = Drive(path);
  controller.result.to_go_m = 6;
  Step(driving);
  Said("", "");
  Step(driving);
  EXPECT_TRUE(Said("plan", "a shorter way"));
  EXPECT_EQ(planner.requests.size(), 1u);
}

TEST_F(DrivingStateTest, DoesNotTakeAPathThatIsHardlyShorterOrFarOff) {
  PlannedPath path = Straight(PoseAtPoint(1, 2), PoseAtPoint(5, 2));
  path.may_be_better = true;
  controller.result.to_go_m = 4.1;
  DrivingState driving = Drive(path);
  Step(driving);
  Step(driving);
  EXPECT_FALSE(Said("plan", "a shorter way"));
  controller.result.to_go_m = 100;
  DrivingState driven_away = Drive(path);
  Step(driven_away);
  robot = Robot(1, 3);
  Step(driven_away);
  EXPECT_FALSE(Said("plan", "a shorter way"));
}

TEST_F(DrivingStateTest, PassesPosesWithoutAStop) {
  goal = CourseTo({PoseAtPoint(5, 2), PoseAtPoint(5, 6)});
  DrivingState driving = Drive();
  EXPECT_TRUE(Is<DrivingState::GoesOn>(Step(driving)));
  Step(driving);
  EXPECT_TRUE(driving.next_leg().has_value());
  robot = Robot(4.8, 2);
  EXPECT_TRUE(Is<DrivingState::PassedPose>(Step(driving)));
  // On another floor it is not there.
  robot.pose.place.height_m = 3;
  EXPECT_TRUE(Is<DrivingState::GoesOn>(Step(driving)));
  // The last one is arrived at.
  goal.status.next_pose = 1;
  robot.pose.place.height_m = 0;
  EXPECT_TRUE(Is<DrivingState::GoesOn>(Step(driving)));
}

TEST_F(DrivingStateTest, ReachesItsGoal) {
  DrivingState driving = Drive();
  controller.result.state = control::ControlState::kArrived;
  EXPECT_TRUE(Is<DrivingState::GoesOn>(Step(driving)));
  robot = Robot(5, 2);
  goal.status.driven_m = 4.2;
  const DrivingState::Result result = Step(driving);
  ASSERT_TRUE(Is<GoalEnd>(result));
  EXPECT_EQ(std::get<GoalEnd>(result.outcome).state, GoalState::kSucceeded);
  EXPECT_EQ(std::get<GoalEnd>(result.outcome).why,
            "0.00 m and 0 degrees off, after 4.2 m");
  EXPECT_EQ(goal.status.to_go_m, 0);
}

TEST_F(DrivingStateTest, DisputesOfArrivalNeedPlansThenAreTrouble) {
  controller.result.state = control::ControlState::kArrived;
  for (int i = 0; i < options.limits.max_replans; ++i) {
    DrivingState driving = Drive();
    EXPECT_TRUE(Is<DrivingState::GoesOn>(Step(driving)));
    EXPECT_TRUE(Is<DrivingState::NeedsPlan>(Step(driving, 2.1)));
  }
  DrivingState driving = Drive();
  Step(driving);
  const DrivingState::Result result = Step(driving, 2.1);
  ASSERT_TRUE(Is<GoalTrouble>(result));
  EXPECT_EQ(std::get<GoalTrouble>(result.outcome).kind, Trouble::kStuck);
}

TEST_F(DrivingStateTest, DrivesToItsGoalWhenThatIsFreeAgain) {
  PlannedPath beside = Straight(PoseAtPoint(1, 2), PoseAtPoint(4.4, 2));
  beside.result.moved_goal_m = 0.6;
  beside.had_blockages = true;
  DrivingState driving = Drive(beside);
  EXPECT_TRUE(Said("plan", "0.60 m beside the goal, where there is room"));
  EXPECT_TRUE(Is<DrivingState::GoesOn>(Step(driving)));
  driving.NoteWayIsFree();
  const DrivingState::Result result = Step(driving);
  EXPECT_TRUE(Is<DrivingState::NeedsPlan>(result));
  EXPECT_EQ(result.command.forward_mps, 0);
  // Where it is the map that has no room, nothing goes away.
  beside.had_blockages = false;
  DrivingState by_the_map = Drive(beside);
  by_the_map.NoteWayIsFree();
  EXPECT_TRUE(Is<DrivingState::GoesOn>(Step(by_the_map)));
}

TEST_F(DrivingStateTest, APlaceWellBesideTheGoalIsNotTheGoal) {
  for (const double beside_m : {0.1, 0.73}) {
    PlannedPath beside =
        Straight(PoseAtPoint(1, 2), PoseAtPoint(5 - beside_m, 2));
    beside.result.moved_goal_m = beside_m;
    DrivingState driving = Drive(beside);
    controller.result.state = control::ControlState::kArrived;
    robot = Robot(5 - beside_m, 2);
    const DrivingState::Result result = Step(driving);
    ASSERT_TRUE(Is<GoalEnd>(result));
    const auto& end = std::get<GoalEnd>(result.outcome);
    EXPECT_EQ(end.state,
              beside_m < 0.5 ? GoalState::kSucceeded : GoalState::kFailed);
    EXPECT_EQ(end.cause, beside_m < 0.5 ? core::NavigationCause::kNone
                                        : core::NavigationCause::kGoalBlocked);
  }
}

TEST_F(DrivingStateTest, RemembersWhatStandsInTheWay) {
  controller.result.state = control::ControlState::kBlocked;
  controller.result.obstacle_in_map = {3, 2};
  controller.result.obstacle_radius_m = 0.2;
  DrivingState driving = Drive();
  EXPECT_TRUE(Is<DrivingState::NeedsPlan>(Step(driving)));
  EXPECT_TRUE(Said("blocked", "something stands in the way at (3.00, 2.00)"));
  const std::vector<planning::Blockage> known = tools.blockages.All();
  ASSERT_EQ(known.size(), 1u);
  EXPECT_EQ(known[0].center.x, 3);
  EXPECT_DOUBLE_EQ(known[0].radius_m, 0.2 + options.limits.blockage_margin_m);
  EXPECT_EQ(known[0].level, 0);
  for (int i = 1; i < options.limits.max_replans; ++i) Step(driving);
  const DrivingState::Result result = Step(driving);
  ASSERT_TRUE(Is<GoalTrouble>(result));
  EXPECT_EQ(std::get<GoalTrouble>(result.outcome).cause,
            core::NavigationCause::kBlocked);
}

TEST_F(DrivingStateTest, WaitsForWhatMoves) {
  controller.result.state = control::ControlState::kWaiting;
  DrivingState driving = Drive();
  EXPECT_TRUE(Is<DrivingState::GoesOn>(Step(driving)));
  EXPECT_TRUE(Said("blocked", "waits for something that moves"));
  const double wait_s = options.limits.wait_for_moving_s;
  EXPECT_TRUE(Is<DrivingState::GoesOn>(Step(driving, wait_s)));
  // It moved on; another one comes.
  controller.result.state = control::ControlState::kDriving;
  Step(driving);
  controller.result.state = control::ControlState::kWaiting;
  EXPECT_TRUE(Is<DrivingState::GoesOn>(Step(driving, 0.1)));
  EXPECT_TRUE(Is<DrivingState::GoesOn>(Step(driving, wait_s)));
  EXPECT_TRUE(Is<DrivingState::NeedsPlan>(Step(driving, 0.1)));
  EXPECT_TRUE(Said("blocked", "what moved does not go away"));
}

TEST_F(DrivingStateTest, WithoutProgressThereIsTrouble) {
  DrivingState driving = Drive();
  EXPECT_TRUE(Is<DrivingState::GoesOn>(Step(driving)));
  EXPECT_TRUE(
      Is<DrivingState::GoesOn>(Step(driving, options.limits.progress_s - 1)));
  controller.result.is_stopped_by_guard = true;
  const DrivingState::Result result = Step(driving, 1);
  ASSERT_TRUE(Is<GoalTrouble>(result));
  EXPECT_EQ(std::get<GoalTrouble>(result.outcome).kind, Trouble::kStuck);
  EXPECT_EQ(std::get<GoalTrouble>(result.outcome).cause,
            core::NavigationCause::kCollisionStop);
}

TEST_F(DrivingStateTest, ProgressGivesAttemptsBack) {
  while (tools.attempts.TakeReplan()) {
  }
  DrivingState driving = Drive();
  controller.result.to_go_m = 4;
  Step(driving);
  EXPECT_FALSE(tools.attempts.TakeReplan());
  controller.result.to_go_m = 4 - options.limits.recovery_reset_m;
  Step(driving);
  EXPECT_TRUE(tools.attempts.TakeReplan());
}

TEST_F(DrivingStateTest, WithoutABandItNeedsAPlan) {
  controller.result.state = control::ControlState::kIdle;
  DrivingState driving = Drive();
  EXPECT_TRUE(Is<DrivingState::NeedsPlan>(Step(driving)));
}

// What stands on the goal comes and goes in what the sensors say.
TEST_F(DrivingStateTest, DoesNotGoToAndFroBeforeAGoalThatFlickers) {
  controller.result.obstacle_in_map = {5, 2};
  std::vector<double> waits_s;
  // It is met at once from the path, and seems free at once from beside.
  for (int i = 0; i < 10; ++i) {
    controller.result.state = control::ControlState::kBlocked;
    DrivingState driving = Drive();
    EXPECT_TRUE(Is<DrivingState::NeedsPlan>(Step(driving)));
    PlannedPath path = Straight(PoseAtPoint(1, 2), PoseAtPoint(4.4, 2));
    path.result.moved_goal_m = 0.6;
    path.had_blockages = true;
    controller.result.state = control::ControlState::kDriving;
    DrivingState beside = Drive(path);
    beside.NoteWayIsFree();
    double waited_s = 0;
    while (waited_s < options.limits.progress_s - 1 &&
           Is<DrivingState::GoesOn>(Step(beside, 0.5))) {
      waited_s += 0.5;
    }
    if (waited_s >= options.limits.progress_s - 1) break;
    waits_s.push_back(waited_s);
  }
  // Then it goes to where there is room, and stays there.
  ASSERT_EQ(waits_s.size(), 2u);
  EXPECT_NEAR(waits_s[0], kFirstWait_s, 0.5);
  EXPECT_NEAR(waits_s[1], 2 * kFirstWait_s, 0.5);
}

TEST_F(DrivingStateTest, WaitsWhereItIsBesideAnOccupiedGoalThenSaysSo) {
  controller.result.state = control::ControlState::kBlocked;
  controller.result.obstacle_in_map = {5.1, 2};
  robot = Robot(4.8, 2, 1.0);
  int waits = 0;
  for (int i = 0; i < 10; ++i) {
    DrivingState driving = Drive();
    DrivingState::Result result = Step(driving);
    if (Is<GoalEnd>(result)) {
      const auto& end = std::get<GoalEnd>(result.outcome);
      EXPECT_EQ(end.state, GoalState::kFailed);
      EXPECT_EQ(end.cause, core::NavigationCause::kGoalBlocked);
      EXPECT_EQ(end.why,
                "stopped 0.20 m beside the goal and 57 degrees off, after 0.0 "
                "m: something stands there");
      break;
    }
    ASSERT_TRUE(Is<DrivingState::GoesOn>(result));
    EXPECT_TRUE(driving.WaitsAtGoal());
    // One event, whatever happens.
    EXPECT_EQ(Said("goal", "waits 0.20 m beside the goal"), waits == 0);
    ++waits;
    double waited_s = 0;
    do {
      result = Step(driving, 0.5);
      EXPECT_EQ(result.command.forward_mps, 0);
      waited_s += 0.5;
    } while (Is<DrivingState::GoesOn>(result) && waited_s < 60);
    EXPECT_TRUE(Is<DrivingState::NeedsPlan>(result));
    EXPECT_LE(waited_s, kGoalWait_s);
  }
  EXPECT_EQ(waits, 2);
  EXPECT_TRUE(tools.blockages.empty());
  // The heading is right: near enough for a pose that is driven through.
  robot = Robot(4.8, 2);
  DrivingState driving = Drive();
  const DrivingState::Result result = Step(driving);
  ASSERT_TRUE(Is<GoalEnd>(result));
  EXPECT_EQ(std::get<GoalEnd>(result.outcome).state, GoalState::kSucceeded);
}

TEST_F(DrivingStateTest, AGoalWithoutRoomToTurnEndsAfterThreeTries) {
  robot = Robot(4.95, 2, 2);
  controller.result.is_stopped_by_guard = true;
  int troubles = 0;
  for (int i = 0; i < 10; ++i) {
    DrivingState driving = Drive();
    Step(driving);
    const DrivingState::Result result =
        Step(driving, options.limits.progress_s);
    if (Is<GoalEnd>(result)) {
      EXPECT_EQ(std::get<GoalEnd>(result.outcome).cause,
                core::NavigationCause::kGoalBlocked);
      EXPECT_TRUE(absl::StrContains(std::get<GoalEnd>(result.outcome).why,
                                    "there is no room to turn"));
      break;
    }
    ASSERT_TRUE(Is<GoalTrouble>(result));
    ++troubles;
  }
  EXPECT_EQ(troubles, 2);
}

}  // namespace
}  // namespace treeline::behavior
