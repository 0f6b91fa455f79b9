#include "nav_agent/behavior/plan_requests.h"

#include "nav_agent/behavior/testing_goal.h"

namespace treeline::behavior {
namespace {

class PlanRequestsTest : public GoalFixture {
 protected:
  void Ask(PlanPurpose purpose) {
    plans.Ask(purpose, PoseAtPoint(1, 2), PoseAtPoint(5, 2),
              {{.center = {3, 2}, .radius_m = 0.3, .level = 0}}, Now());
  }

  PlanRequests& plans = tools.plans;
};

TEST_F(PlanRequestsTest, AnswersOnceWithWhatItWasFor) {
  EXPECT_FALSE(plans.Take().has_value());
  Ask(PlanPurpose::kBetter);
  EXPECT_TRUE(plans.IsOpen());
  planner.holds = true;
  EXPECT_FALSE(plans.Take().has_value());
  EXPECT_TRUE(plans.IsOpen());
  planner.holds = false;
  const auto answer = plans.Take();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->purpose, PlanPurpose::kBetter);
  EXPECT_TRUE(answer->had_blockages);
  EXPECT_TRUE(answer->HasPath());
  EXPECT_FALSE(plans.IsOpen());
  EXPECT_FALSE(plans.Take().has_value());
}

TEST_F(PlanRequestsTest, AskWhetherThereIsAWayButForWhatWasSeen) {
  Ask(PlanPurpose::kUnblocked);
  EXPECT_TRUE(planner.requests.back().blockages.empty());
  EXPECT_FALSE(planner.budgets.back().improves);
  EXPECT_FALSE(plans.Take()->had_blockages);
  Ask(PlanPurpose::kFullRoute);
  EXPECT_EQ(planner.requests.back().blockages.size(), 1u);
  EXPECT_TRUE(planner.budgets.back().improves);
}

TEST_F(PlanRequestsTest, OnlyWhatTheRobotWaitsForIsQuick) {
  for (const PlanPurpose purpose :
       {PlanPurpose::kRoute, PlanPurpose::kUnblocked, PlanPurpose::kFullRoute,
        PlanPurpose::kBetter, PlanPurpose::kNextLeg}) {
    Ask(purpose);
    const bool is_quick =
        purpose <= PlanPurpose::kRoute || purpose == PlanPurpose::kUnblocked;
    EXPECT_EQ(planner.budgets.back().max_iterations,
              is_quick ? options.first_plan_budget.max_iterations
                       : options.plan_budget.max_iterations);
  }
}

TEST_F(PlanRequestsTest, EachPlanHasASeedOfItsOwn) {
  Ask(PlanPurpose::kRoute);
  Ask(PlanPurpose::kRoute);
  EXPECT_NE(planner.requests[0].seed, planner.requests[1].seed);
  PlanRequests again(planner, options);
  again.Ask(PlanPurpose::kRoute, PoseAtPoint(1, 2), PoseAtPoint(5, 2), {},
            Now());
  EXPECT_EQ(planner.requests[2].seed, planner.requests[0].seed);
}

TEST_F(PlanRequestsTest, APlanThatTakesTooLongHasFailed) {
  planner.holds = true;
  Ask(PlanPurpose::kFullRoute);
  clock.Advance_s(options.limits.plan_s - 0.1);
  EXPECT_FALSE(plans.TakeInTime(Now()).has_value());
  EXPECT_TRUE(planner.IsBusy());
  clock.Advance_s(0.1);
  const auto answer = plans.TakeInTime(Now());
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->purpose, PlanPurpose::kFullRoute);
  EXPECT_TRUE(answer->had_blockages);
  EXPECT_FALSE(answer->HasPath());
  EXPECT_EQ(answer->result->failure, core::NavigationCause::kPlanTimeout);
  EXPECT_FALSE(planner.IsBusy());
  EXPECT_FALSE(plans.IsOpen());
}

TEST_F(PlanRequestsTest, OfWhatIsCancelledNothingComes) {
  Ask(PlanPurpose::kRoute);
  plans.Cancel();
  EXPECT_FALSE(planner.IsBusy());
  EXPECT_FALSE(plans.IsOpen());
  EXPECT_FALSE(plans.Take().has_value());
  EXPECT_FALSE(plans.TakeInTime(Now()).has_value());
}

TEST_F(PlanRequestsTest, ErrorsFailuresAndEmptyPathsAreNoPaths) {
  Answer(absl::InvalidArgumentError("odd"));
  AnswerFailure(core::NavigationCause::kNoPath);
  Answer(planning::PlanResult());
  for (int i = 0; i < 3; ++i) {
    Ask(PlanPurpose::kRoute);
    EXPECT_FALSE(plans.Take()->HasPath()) << i;
  }
}

}  // namespace
}  // namespace treeline::behavior
