#include "nav_agent/behavior/navigator.h"

#include <limits>

#include "nav_agent/behavior/testing_navigator.h"

namespace treeline::behavior {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

using NavigatorTest = NavigatorFixture;

TEST_F(NavigatorTest, WaitsToBeToldWhereItIs) {
  Make();
  Run(0.1);
  EXPECT_EQ(mode(), NavigatorMode::kNeedHelp);
  EXPECT_EQ(navigator->Snapshot().cause, core::NavigationCause::kNeedHelp);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  Send({PoseAtPoint(5, 5)});
  Run(0.1);
  EXPECT_EQ(Goal().state, GoalState::kAccepted);
  EXPECT_TRUE(planner->requests.empty());
  ASSERT_TRUE(navigator->SetPose(PoseAtPoint(2, 2), {}).ok());
  Run(0.1);
  EXPECT_EQ(lost->told, 1);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
}

TEST_F(NavigatorTest, LooksForItselfAtStartIfItMay) {
  NavigatorOptions options;
  options.finds_itself_at_start = true;
  Make(options);
  Run(0.1);
  ASSERT_EQ(lost->begun.size(), 1u);
  EXPECT_EQ(lost->begun[0], RelocalizationCause::kStart);
  EXPECT_EQ(mode(), NavigatorMode::kLost);
}

TEST_F(NavigatorTest, PlansDrivesAndArrives) {
  MakePlaced();
  EXPECT_EQ(mode(), NavigatorMode::kIdle);
  EXPECT_EQ(Send({PoseAtPoint(5, 2)}), 1u);
  planner->holds = true;
  Run(0.05);
  EXPECT_EQ(mode(), NavigatorMode::kPlanning);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  planner->holds = false;
  Run(0.05);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(controller->path.size(), 2u);
  EXPECT_EQ(Last().forward_mps, 0.5);
  EXPECT_EQ(Goal().state, GoalState::kActive);
  EXPECT_DOUBLE_EQ(Goal().to_go_m, 5);
  tracker->pose = PoseAtPoint(5, 2);
  controller->result.state = control::ControlState::kArrived;
  controller->result.command = {};
  Run(0.05);
  EXPECT_EQ(Goal().state, GoalState::kSucceeded);
  EXPECT_EQ(Goal().next_pose, 1u);
  EXPECT_EQ(mode(), NavigatorMode::kIdle);
  EXPECT_TRUE(controller->path.empty());
  EXPECT_EQ(Count("goal", "reached"), 1);
}

TEST_F(NavigatorTest, AGoalIsReachedOnlyWithinToleranceAndStanding) {
  MakePlaced();
  Send({PoseAtPoint(5, 2)});
  Run(0.05);
  controller->result.state = control::ControlState::kArrived;
  tracker->pose = PoseAtPoint(4.7, 2);
  Run(1);
  EXPECT_EQ(Goal().state, GoalState::kActive);
  tracker->pose = PoseAtPoint(5, 2, 0.4);
  Run(0.5);
  EXPECT_EQ(Goal().state, GoalState::kActive);
  tracker->pose = PoseAtPoint(5, 2);
  reading.forward_mps = 0.2;
  Run(0.3);
  EXPECT_EQ(Goal().state, GoalState::kActive);
  reading.forward_mps = 0;
  Run(0.05);
  EXPECT_EQ(Goal().state, GoalState::kSucceeded);
}

// Something stands at the goal: the robot waits beside it for a while.
class TakenGoalTest : public NavigatorFixture {
 protected:
  void ArriveBeside() {
    MakePlaced();
    Send({PoseAtPoint(5, 2)});
    Run(0.05);
    controller->result.state = control::ControlState::kBlocked;
    controller->result.obstacle_in_map = {5, 2};
    controller->result.obstacle_radius_m = 0.2;
    planning::PlanResult beside =
        FakePlannerWorker::Straight(PoseAtPoint(2, 2), PoseAtPoint(4.4, 2));
    beside.moved_goal_m = 0.6;
    // Better ways that are looked for meanwhile, too.
    planner->answers.assign(5, beside);
    Run(0.025);
    controller->result = {};
    controller->result.state = control::ControlState::kArrived;
    tracker->pose = PoseAtPoint(4.4, 2);
    // The laser sees it, 0.22 m before the base.
    laser_range_m = 0.3F;
    Run(0.5);
    ASSERT_EQ(Goal().state, GoalState::kActive);
  }
};

TEST_F(TakenGoalTest, IsGivenUpBesideAfterAWait) {
  ArriveBeside();
  Run(9);
  EXPECT_EQ(Goal().state, GoalState::kActive);
  Run(2);
  EXPECT_EQ(Goal().state, GoalState::kFailed);
  EXPECT_EQ(Goal().cause, core::NavigationCause::kGoalBlocked);
  EXPECT_DOUBLE_EQ(Goal().to_go_m, 0.6);
  // One event says what is waited for, one how it ended.
  EXPECT_EQ(Count("goal", "waits 0.60 m beside the goal, where something"), 1);
  EXPECT_EQ(Count("goal", "at a place 0.60 m beside the goal, where some"), 1);
}

TEST_F(TakenGoalTest, IsDrivenToWhenItIsFree) {
  ArriveBeside();
  const size_t asked = planner->requests.size();
  Run(3);
  EXPECT_EQ(planner->requests.size(), asked);
  planner->answers.clear();
  // The laser looks through what stood there.
  laser_range_m = 3;
  Run(2);
  EXPECT_EQ(Count("blocked", "the obstacle in the way is gone"), 1);
  ASSERT_GT(planner->requests.size(), asked);
  EXPECT_EQ(planner->requests.back().goal.map_from_base.translation.x, 5);
  EXPECT_TRUE(planner->requests.back().blockages.empty());
  EXPECT_EQ(controller->path.back().map_from_base.translation.x, 5);
  controller->result.state = control::ControlState::kArrived;
  tracker->pose = PoseAtPoint(5, 2);
  Run(0.5);
  EXPECT_EQ(Goal().state, GoalState::kSucceeded);
  EXPECT_EQ(Count("goal", "waits 0.60 m beside the goal"), 1);
  EXPECT_EQ(Count("goal", "at a place"), 0);
}

// A controller that says that it has arrived and has not gets new plans, then
// recoveries, then an end.
TEST_F(NavigatorTest, ADisputeAboutArrivalEnds) {
  MakePlaced();
  Send({PoseAtPoint(5, 2)});
  controller->result.state = control::ControlState::kArrived;
  controller->result.command = {};
  Run(400);
  EXPECT_EQ(Goal().state, GoalState::kFailed);
  EXPECT_EQ(Goal().cause, core::NavigationCause::kNoProgress);
}

TEST_F(NavigatorTest, RefusesGoalsThatAreNone) {
  MakePlaced();
  EXPECT_EQ(navigator->SetGoal({}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(navigator->SetGoal({{PoseAtPoint(kNaN, 1)}}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(navigator->SetGoal({{PoseAtPoint(1, 1, 0, 2)}}).status().message(),
            "a goal on level 2; the map has levels 0 to 1");
  EXPECT_EQ(navigator->SetPose(PoseAtPoint(1, kNaN), {}).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_FALSE(navigator->goal().has_value());
}

TEST_F(NavigatorTest, ANewGoalPreempts) {
  MakePlaced();
  const uint64_t first = Send({PoseAtPoint(5, 2)});
  Run(0.1);
  const uint64_t second = Send({PoseAtPoint(2, 5)});
  EXPECT_NE(first, second);
  Run(0.1);
  EXPECT_EQ(Count("goal", "(preempted)"), 1);
  EXPECT_EQ(Goal().id, second);
  EXPECT_EQ(planner->requests.back().goal.map_from_base.translation.y, 5);
  EXPECT_EQ(navigator->CancelGoal(first).code(), absl::StatusCode::kNotFound);
}

TEST_F(NavigatorTest, CancelStopsAndTheNextGoalIsAccepted) {
  MakePlaced();
  const uint64_t id = Send({PoseAtPoint(5, 2)});
  Run(0.1);
  ASSERT_TRUE(navigator->CancelGoal(id).ok());
  EXPECT_EQ(Goal().state, GoalState::kCancelled);
  EXPECT_EQ(Goal().cause, core::NavigationCause::kCancelled);
  Run(0.05);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  EXPECT_EQ(mode(), NavigatorMode::kIdle);
  EXPECT_EQ(navigator->CancelGoal(0).code(), absl::StatusCode::kNotFound);
  Send({PoseAtPoint(2, 5)});
  Run(0.1);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
}

TEST_F(NavigatorTest, PauseStandsAndResumePlansAnew) {
  MakePlaced();
  Send({PoseAtPoint(5, 2)});
  Run(0.1);
  const size_t plans = planner->requests.size();
  navigator->Pause();
  Run(0.1);
  EXPECT_EQ(mode(), NavigatorMode::kPaused);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  EXPECT_EQ(Goal().state, GoalState::kActive);
  navigator->Resume();
  Run(0.1);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_GT(planner->requests.size(), plans);
}

TEST_F(NavigatorTest, PosesAreDrivenThroughAndTheWayOnIsKnownBefore) {
  MakePlaced();
  Send({PoseAtPoint(4, 2, 3), PoseAtPoint(4, 6, 1)});
  Run(0.2);
  // The heading of a pose that is driven through is that of the way.
  EXPECT_NEAR(planner->requests[0].goal.map_from_base.yaw_rad, M_PI / 2, 1e-9);
  // The first, a better one, and the way on.
  ASSERT_EQ(planner->requests.size(), 3u);
  EXPECT_EQ(planner->requests[2].goal.map_from_base.yaw_rad, 1);
  EXPECT_EQ(Goal().next_pose, 0u);
  tracker->pose = PoseAtPoint(3.8, 2);
  Run(0.025);
  EXPECT_EQ(Goal().next_pose, 1u);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(planner->requests.size(), 3u);
  EXPECT_EQ(controller->path.back().map_from_base.translation.y, 6);
}

TEST_F(NavigatorTest, ABetterPathIsTakenOnlyIfItIsNotablyShorter) {
  MakePlaced();
  planning::PlanResult detour =
      FakePlannerWorker::Straight(PoseAtPoint(2, 2), PoseAtPoint(7, 2));
  detour.path.insert(detour.path.begin() + 1, PoseAtPoint(4, 6));
  detour.length_m = 9.5;
  controller->result.to_go_m = 9.5;
  planner->answers.emplace_back(detour);
  Send({PoseAtPoint(7, 2)});
  Run(0.1);
  EXPECT_EQ(controller->path.size(), 2u);
  EXPECT_EQ(Count("plan", "a shorter way"), 1);
  EXPECT_EQ(Goal().replans, 0);
  // 5 m instead of 5.2 are not worth it.
  controller->result.to_go_m = 5.2;
  detour.length_m = 5.2;
  planner->answers.emplace_back(detour);
  Send({PoseAtPoint(7, 2)});
  Run(0.1);
  EXPECT_EQ(controller->path.size(), 3u);
}

TEST_F(NavigatorTest, PlanFailuresEndTheGoalWithTheirCause) {
  MakePlaced();
  for (const core::NavigationCause cause :
       {core::NavigationCause::kGoalBlocked,
        core::NavigationCause::kGoalOutside, core::NavigationCause::kNoPath}) {
    planner->answers.emplace_back(
        FakePlannerWorker::Failure(cause, "so it is"));
    Send({PoseAtPoint(5, 2)});
    Run(0.1);
    EXPECT_EQ(Goal().state, GoalState::kFailed);
    EXPECT_EQ(Goal().cause, cause);
    EXPECT_TRUE(absl::StrContains(Goal().why, "so it is"));
  }
  planner->answers.emplace_back(absl::InvalidArgumentError("odd"));
  Send({PoseAtPoint(5, 2)});
  Run(0.1);
  EXPECT_EQ(Goal().cause, core::NavigationCause::kInternal);
}

// A robot that its way has led to a place that is too narrow by the map.
TEST_F(NavigatorTest, WithoutAWayOnFromWhereItDroveItRecovers) {
  MakePlaced();
  Send({PoseAtPoint(7, 2)});
  Run(0.1);
  controller->result.state = control::ControlState::kIdle;
  planner->answers.emplace_back(FakePlannerWorker::Failure(
      core::NavigationCause::kNoPath, "too narrow to turn in"));
  Run(0.05);
  EXPECT_EQ(Goal().state, GoalState::kActive);
  EXPECT_GE(Goal().recoveries, 1);
  controller->result.state = control::ControlState::kDriving;
  Run(NavigatorLimits{}.first_wait_s + 1);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(Count("recovery", "wait: done"), 1);
}

TEST_F(NavigatorTest, APlanThatTakesTooLongIsAskedForWithMoreTime) {
  MakePlaced();
  planner->answers.emplace_back(FakePlannerWorker::Failure(
      core::NavigationCause::kPlanTimeout, "too hard"));
  Send({PoseAtPoint(5, 2)});
  Run(0.1);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_GT(planner->budgets[1].max_iterations,
            planner->budgets[0].max_iterations);
}

TEST_F(NavigatorTest, WhatStandsInTheWayIsPlannedAround) {
  MakePlaced();
  Send({PoseAtPoint(7, 2)});
  Run(0.1);
  controller->result.state = control::ControlState::kBlocked;
  controller->result.obstacle_in_map = {4, 2};
  controller->result.obstacle_radius_m = 0.3;
  Run(0.025);
  controller->result.state = control::ControlState::kDriving;
  Run(0.025);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(Goal().replans, 1);
  EXPECT_EQ(Goal().recoveries, 0);
  ASSERT_EQ(planner->requests.back().blockages.size(), 1u);
  EXPECT_EQ(planner->requests.back().blockages[0].center.x, 4);
  EXPECT_EQ(navigator->Snapshot().blockages.size(), 1u);
  // It fades.
  Run(40);
  EXPECT_TRUE(navigator->Snapshot().blockages.empty());
}

// Recoveries come one after another, have ends, and there are not more of them
// than the goal's budget.
TEST_F(NavigatorTest, RecoveriesEscalateAndEnd) {
  MakePlaced();
  Send({PoseAtPoint(7, 2)});
  Run(0.1);
  controller->result.state = control::ControlState::kBlocked;
  controller->result.obstacle_in_map = {4, 2};
  controller->result.obstacle_radius_m = 0.3;
  const auto blocked = [&](const planning::PlanRequest& request) {
    return !request.blockages.empty();
  };
  for (int i = 0; i < 40000 && Goal().state == GoalState::kActive; ++i) {
    // No way around it, and one without it.
    planner->answers.clear();
    for (int k = 0; k < 4; ++k) {
      planner->answers.emplace_back(FakePlannerWorker::Failure(
          core::NavigationCause::kNoPath, "walls everywhere"));
      planner->answers.emplace_back(
          FakePlannerWorker::Straight(PoseAtPoint(2, 2), PoseAtPoint(7, 2)));
    }
    if (!planner->requests.empty() && !blocked(planner->requests.back())) {
      planner->answers.pop_front();
    }
    Run(0.025);
  }
  EXPECT_EQ(Goal().state, GoalState::kFailed);
  EXPECT_EQ(Goal().cause, core::NavigationCause::kBlocked);
  EXPECT_EQ(Goal().recoveries, NavigatorLimits{}.max_recoveries);
  EXPECT_GE(Count("recovery", "back up"), 1);
  EXPECT_GE(Count("recovery", "clear costmap"), 1);
  EXPECT_GE(Count("recovery", "wait"), 1);
  Send({PoseAtPoint(2, 5)});
  controller->result.state = control::ControlState::kDriving;
  planner->answers.clear();
  Run(0.1);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
}

TEST_F(NavigatorTest, WithoutProgressItRecoversThenFails) {
  MakePlaced();
  Send({PoseAtPoint(7, 2)});
  Run(9);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  Run(2);
  EXPECT_GE(Count("recovery", "no_progress"), 1);
  Run(400);
  EXPECT_EQ(Goal().state, GoalState::kFailed);
  EXPECT_EQ(Goal().cause, core::NavigationCause::kNoProgress);
}

TEST_F(NavigatorTest, WaitsForWhatMovesButNotForEver) {
  MakePlaced();
  Send({PoseAtPoint(7, 2)});
  Run(0.1);
  controller->result.state = control::ControlState::kWaiting;
  controller->result.command = {};
  controller->result.obstacle_in_map = {4, 2};
  Run(NavigatorLimits{}.wait_for_moving_s - 0.5);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(Goal().replans, 0);
  Run(1);
  EXPECT_EQ(Goal().replans, 1);
  EXPECT_EQ(Count("blocked", "does not go away"), 1);
}

TEST_F(NavigatorTest, LostMeansThatTheSearchDrives) {
  MakePlaced();
  Send({PoseAtPoint(7, 2)});
  Run(0.1);
  lost->now_state = RelocalizationState::kStopping;
  lost->wanted = {.forward_mps = 0, .yaw_rate_radps = 0.3};
  Run(0.025);
  EXPECT_EQ(mode(), NavigatorMode::kLost);
  EXPECT_EQ(navigator->Snapshot().cause, core::NavigationCause::kEstimateLost);
  Run(0.05);
  // Its pose on the map is not used any more, only odometry.
  EXPECT_TRUE(controller->last_guarded->map_is_unknown);
  EXPECT_TRUE(controller->last_scan_pose->map_is_unknown);
  lost->now_state = RelocalizationState::kAsking;
  Run(0.05);
  EXPECT_EQ(mode(), NavigatorMode::kRelocalizing);
  EXPECT_EQ(Last().yaw_rate_radps, 0.3);
  EXPECT_EQ(Goal().state, GoalState::kActive);
  lost->now_state = RelocalizationState::kNeedHelp;
  Run(0.05);
  EXPECT_EQ(mode(), NavigatorMode::kNeedHelp);
  EXPECT_EQ(navigator->Snapshot().cause, core::NavigationCause::kNeedHelp);
  // Found: the goal goes on from where it is.
  tracker->pose = PoseAtPoint(8, 8);
  lost->now_state = RelocalizationState::kFound;
  Run(0.025);
  lost->now_state = RelocalizationState::kIdle;
  Run(0.05);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(controller->path.front().map_from_base.translation.x, 8);
  EXPECT_FALSE(controller->last_scan_pose->map_is_unknown);
}

TEST_F(NavigatorTest, InDoubtItKeepsAwayFromWhatAnyPlaceHasAndTheGoalWaits) {
  MakePlaced();
  Send({PoseAtPoint(7, 2)});
  Run(0.1);
  lost->now_state = RelocalizationState::kSearching;
  lost->wanted = {.forward_mps = 0.1, .yaw_rate_radps = 0};
  // It is not known yet what is possible.
  tracker->place_share = 0;
  Run(0.05);
  EXPECT_TRUE(controller->last_guarded->supposed.empty());
  // Places that are hardly possible do not count.
  tracker->place_share = 0.5;
  tracker->others = {{.pose = PoseAtPoint(8, 3), .share = 0.3},
                     {.pose = PoseAtPoint(8, 2), .share = 0.2}};
  Run(0.05);
  ASSERT_EQ(controller->last_guarded->supposed.size(), 2u);
  EXPECT_EQ(controller->last_guarded->supposed[0], *tracker->pose);
  EXPECT_EQ(controller->last_guarded->supposed[1], PoseAtPoint(8, 3));
  tracker->place_share = 0.2;
  tracker->others[0].share = 0.8;
  Run(0.05);
  ASSERT_EQ(controller->last_guarded->supposed.size(), 1u);
  EXPECT_EQ(controller->last_guarded->supposed[0], PoseAtPoint(8, 3));
  // The search drives, not the goal, for however long.
  Run(5);
  EXPECT_EQ(mode(), NavigatorMode::kRelocalizing);
  EXPECT_EQ(Last().forward_mps, 0.1);
  EXPECT_EQ(Goal().state, GoalState::kActive);
  // The doubt is over: on to the goal, from where it turned out to be.
  tracker->place_share = 1;
  tracker->others.clear();
  tracker->pose = PoseAtPoint(8, 8);
  lost->now_state = RelocalizationState::kFound;
  Run(0.025);
  lost->now_state = RelocalizationState::kIdle;
  Run(0.05);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(controller->path.front().map_from_base.translation.x, 8);
  EXPECT_EQ(controller->path.back().map_from_base.translation.x, 7);
}

// An edge that no sensor sees stays where the map has it, however long it holds
// a robot of which only one place is left.
TEST_F(NavigatorTest, OnlyPlacesAmongOthersAreGivenUpWhereTheyHoldIt) {
  MakePlaced();
  Send({PoseAtPoint(7, 2)});
  Run(0.1);
  lost->now_state = RelocalizationState::kSearching;
  lost->wanted = {.forward_mps = 0.1, .yaw_rate_radps = 0};
  controller->guard_stops = true;
  tracker->place_share = 1;
  Run(2 * kSearchHeld_s);
  ASSERT_EQ(controller->last_guarded->supposed.size(), 1u);
  tracker->place_share = 0.5;
  tracker->others = {{.pose = PoseAtPoint(8, 3), .share = 0.5}};
  Run(2 * kSearchHeld_s);
  EXPECT_TRUE(controller->last_guarded->supposed.empty());
}

TEST_F(NavigatorTest, APersonMayAskItToFindItself) {
  MakePlaced();
  navigator->FindYourself();
  Run(0.05);
  ASSERT_EQ(lost->begun.size(), 1u);
  EXPECT_EQ(lost->begun[0], RelocalizationCause::kPerson);
  EXPECT_EQ(mode(), NavigatorMode::kLost);
}

TEST_F(NavigatorTest, TakesPicturesAtALowRate) {
  NavigatorOptions options;
  options.depth_hz = 4;
  MakePlaced(options);
  camera.takes = 0;
  for (int i = 0; i < 20; ++i) {
    core::RgbdFrame frame;
    frame.stamp = clock.Now();
    camera.waiting.push_back(frame);
    Run(0.1);
  }
  EXPECT_EQ(camera.takes, 8);
  EXPECT_EQ(controller->frames, 8);
  EXPECT_EQ(lost->frames, 8);
}

TEST_F(NavigatorTest, ALostRobotHasPicturesWithoutADepthRate) {
  NavigatorOptions options;
  options.depth_hz = 0;
  MakePlaced(options);
  const auto wait = [this] {
    for (int i = 0; i < 20; ++i) {
      core::RgbdFrame frame;
      frame.stamp = clock.Now();
      camera.waiting.push_back(frame);
      Run(0.1);
    }
  };
  wait();
  EXPECT_EQ(lost->frames, 0);
  lost->wants_pictures = true;
  wait();
  EXPECT_GE(lost->frames, 10);
}

TEST_F(NavigatorTest, EveryStepCommandsAndHaltIsForGood) {
  MakePlaced();
  Send({PoseAtPoint(7, 2)});
  base.commands.clear();
  Run(1);
  EXPECT_EQ(base.commands.size(), 40u);
  navigator->Halt();
  EXPECT_GE(base.stops, 1);
  base.commands.clear();
  Run(1);
  EXPECT_EQ(base.commands.size(), 40u);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  EXPECT_EQ(Goal().state, GoalState::kCancelled);
}

TEST_F(NavigatorTest, EventsAreNumberedWithoutGaps) {
  MakePlaced();
  Send({PoseAtPoint(7, 2)});
  Run(15);
  ASSERT_GT(events.size(), 3u);
  for (size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].number, i + 1);
  }
}

TEST_F(NavigatorTest, OptionsAreChecked) {
  NavigatorOptions options;
  EXPECT_TRUE(options.Validate().ok());
  options.control_hz = 5;
  EXPECT_EQ(options.Validate().message(),
            "control_hz is 5; it must be 10..200");
  options = {};
  options.limits.back_up_m = -1;
  EXPECT_EQ(options.Validate().code(), absl::StatusCode::kInvalidArgument);
  options = {};
  options.plan_steps = 4;
  EXPECT_TRUE(options.Validate().ok());
  options.plans_in_background = true;
  EXPECT_EQ(options.Validate().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::behavior
