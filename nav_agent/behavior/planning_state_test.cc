#include "nav_agent/behavior/planning_state.h"

#include <variant>

#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/testing_goal.h"

namespace treeline::behavior {
namespace {

class PlanningStateTest : public GoalFixture {
 protected:
  PlanningState::Outcome Plan() {
    PlanningState planning(goal, robot, tools, Now());
    return planning.Step(goal, robot, tools, Now());
  }

  core::LevelPose robot = PoseAtPoint(1, 2);
};

TEST_F(PlanningStateTest, WaitsForAPath) {
  planner.holds = true;
  PlanningState planning(goal, robot, tools, Now());
  EXPECT_EQ(planning.Step(goal, robot, tools, Now()).index(), 0u);
  planner.holds = false;
  const auto outcome = planning.Step(goal, robot, tools, Now());
  const auto& path = std::get<PlannedPath>(outcome);
  EXPECT_EQ(path.result.path.size(), 2u);
  EXPECT_FALSE(path.had_blockages);
  // The first budget is small.
  EXPECT_TRUE(path.may_be_better);
}

TEST_F(PlanningStateTest, AsksWithMoreTime) {
  AnswerFailure(core::NavigationCause::kPlanTimeout);
  const auto path = std::get<PlannedPath>(Plan());
  EXPECT_EQ(planner.requests.size(), 2u);
  EXPECT_GT(planner.budgets[1].max_iterations,
            planner.budgets[0].max_iterations);
  EXPECT_FALSE(path.may_be_better);
}

TEST_F(PlanningStateTest, SaysThatWhatWasSeenIsInTheWay) {
  Block({3, 2});
  AnswerFailure(core::NavigationCause::kNoPath, "walls everywhere");
  const auto trouble = std::get<GoalTrouble>(Plan());
  EXPECT_TRUE(planner.requests.back().blockages.empty());
  EXPECT_EQ(trouble.kind, Trouble::kNoWay);
  EXPECT_EQ(trouble.cause, core::NavigationCause::kBlocked);
  EXPECT_EQ(trouble.why,
            "what stands in the way leaves no other: walls everywhere");
}

TEST_F(PlanningStateTest, WaitsForAnOccupiedGoalThenSaysHowFarBesideItStands) {
  Block({5.2, 2});
  AnswerFailure(core::NavigationCause::kNoPath, "a crate");
  const auto trouble = std::get<GoalTrouble>(Plan());
  EXPECT_EQ(trouble.kind, Trouble::kOccupied);
  EXPECT_EQ(trouble.cause, core::NavigationCause::kGoalBlocked);
  clock.Advance_s(kBlockageMemory_s + 0.1);
  AnswerFailure(core::NavigationCause::kNoPath, "a crate");
  const auto end = std::get<GoalEnd>(Plan());
  EXPECT_EQ(end.state, GoalState::kFailed);
  EXPECT_EQ(end.cause, core::NavigationCause::kGoalBlocked);
  EXPECT_EQ(end.why, "the goal is occupied: stopped 4.00 m beside it");
  // A pose that is driven through is no goal.
  goal = CourseTo({PoseAtPoint(5, 2), PoseAtPoint(8, 2)});
  AnswerFailure(core::NavigationCause::kNoPath, "a crate");
  EXPECT_EQ(std::get<GoalTrouble>(Plan()).kind, Trouble::kNoWay);
}

TEST_F(PlanningStateTest, KnowsThatItIsEnclosed) {
  Block({1, 2});
  AnswerFailure(core::NavigationCause::kStartBlocked);
  EXPECT_EQ(std::get<GoalTrouble>(Plan()).kind, Trouble::kEnclosed);
  // By the map.
  AnswerFailure(core::NavigationCause::kStartBlocked);
  AnswerFailure(core::NavigationCause::kStartBlocked);
  const auto trouble = std::get<GoalTrouble>(Plan());
  EXPECT_EQ(trouble.kind, Trouble::kEnclosed);
  EXPECT_EQ(trouble.cause, core::NavigationCause::kStartBlocked);
}

TEST_F(PlanningStateTest, AsksAgainIfWhatStoodThereIsGone) {
  Block({3, 2});
  planner.holds = true;
  PlanningState planning(goal, robot, tools, Now());
  EXPECT_EQ(planning.Step(goal, robot, tools, Now()).index(), 0u);
  tools.blockages.Clear();
  planning.NoteWayIsFree();
  AnswerFailure(core::NavigationCause::kNoPath, "a crate");
  planner.holds = false;
  const auto outcome = planning.Step(goal, robot, tools, Now());
  EXPECT_FALSE(std::get<PlannedPath>(outcome).had_blockages);
  ASSERT_EQ(planner.requests.size(), 2u);
  EXPECT_EQ(planner.requests[0].blockages.size(), 1u);
  EXPECT_TRUE(planner.requests[1].blockages.empty());
}

TEST_F(PlanningStateTest, AsksAtMostForThreePlans) {
  Block({3, 2});
  for (int i = 0; i < 5; ++i) {
    AnswerFailure(core::NavigationCause::kPlanTimeout);
  }
  const auto trouble = std::get<GoalTrouble>(Plan());
  EXPECT_EQ(planner.requests.size(), 3u);
  EXPECT_EQ(trouble.cause, core::NavigationCause::kPlanTimeout);
}

TEST_F(PlanningStateTest, WithoutAWayByTheMapTheGoalFails) {
  AnswerFailure(core::NavigationCause::kNoPath, "a wall");
  const auto end = std::get<GoalEnd>(Plan());
  EXPECT_EQ(end.state, GoalState::kFailed);
  EXPECT_EQ(end.cause, core::NavigationCause::kNoPath);
  EXPECT_EQ(end.why,
            "a wall, from (1.00, 2.00) on level 0 to (5.00, 2.00) on level 0");
}

TEST_F(PlanningStateTest, WhereItsWayLedThereIsTroubleOnly) {
  goal.is_first_path = false;
  AnswerFailure(core::NavigationCause::kNoPath);
  EXPECT_EQ(std::get<GoalTrouble>(Plan()).kind, Trouble::kNoWay);
  // Another robot would not get to such a goal either.
  AnswerFailure(core::NavigationCause::kGoalBlocked);
  EXPECT_EQ(std::get<GoalEnd>(Plan()).cause,
            core::NavigationCause::kGoalBlocked);
}

TEST_F(PlanningStateTest, ErrorsOfThePlannerAreInternal) {
  Answer(absl::InvalidArgumentError("odd"));
  const auto error = std::get<GoalEnd>(Plan());
  EXPECT_EQ(error.cause, core::NavigationCause::kInternal);
  EXPECT_EQ(error.why, "the planner: odd");
  Answer(planning::PlanResult());
  EXPECT_EQ(std::get<GoalEnd>(Plan()).why, "the planner found an empty path");
}

TEST_F(PlanningStateTest, DoesNotWaitForEver) {
  planner.holds = true;
  PlanningState planning(goal, robot, tools, Now());
  clock.Advance_s(options.limits.plan_s + 0.01);
  // The plan with more time has its own time.
  EXPECT_EQ(planning.Step(goal, robot, tools, Now()).index(), 0u);
  clock.Advance_s(options.limits.plan_s + 0.01);
  const auto outcome = planning.Step(goal, robot, tools, Now());
  EXPECT_EQ(std::get<GoalTrouble>(outcome).cause,
            core::NavigationCause::kPlanTimeout);
}

}  // namespace
}  // namespace treeline::behavior
