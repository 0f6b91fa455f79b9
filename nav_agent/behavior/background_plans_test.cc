#include "nav_agent/behavior/background_plans.h"

#include "nav_agent/behavior/testing_goal.h"

namespace treeline::behavior {
namespace {

class BackgroundPlansTest : public GoalFixture {
 protected:
  BackgroundPlansTest() {
    goal = CourseTo({PoseAtPoint(5, 2), PoseAtPoint(5, 6)});
    tools.route.path = {PoseAtPoint(1, 2), PoseAtPoint(4.9, 2)};
  }
  std::optional<PlannedPath> Step(BackgroundPlans& plans) {
    return plans.Step(goal, PoseAtPoint(1, 2), tools, Now());
  }
};

TEST_F(BackgroundPlansTest, ABetterPathThenTheNextLeg) {
  BackgroundPlans plans(true);
  EXPECT_FALSE(Step(plans).has_value());
  EXPECT_EQ(planner.requests.back().goal.map_from_base.translation.x, 5);
  const auto better = Step(plans);
  ASSERT_TRUE(better.has_value());
  EXPECT_FALSE(better->may_be_better);
  EXPECT_FALSE(plans.next_leg().has_value());
  EXPECT_FALSE(Step(plans).has_value());
  // From where this path ends.
  EXPECT_EQ(planner.requests.back().start.map_from_base.translation.x, 4.9);
  EXPECT_EQ(planner.requests.back().goal.map_from_base.translation.y, 6);
  EXPECT_FALSE(Step(plans).has_value());
  ASSERT_TRUE(plans.next_leg().has_value());
  // No more is asked.
  EXPECT_FALSE(Step(plans).has_value());
  EXPECT_EQ(planner.requests.size(), 2u);
}

TEST_F(BackgroundPlansTest, TheLastLegHasNoNext) {
  goal.status.next_pose = 1;
  BackgroundPlans plans(false);
  EXPECT_FALSE(Step(plans).has_value());
  EXPECT_TRUE(planner.requests.empty());
}

TEST_F(BackgroundPlansTest, WhatFailsIsNotAskedAgain) {
  AnswerFailure(core::NavigationCause::kNoPath);
  Answer(absl::InternalError("odd"));
  BackgroundPlans plans(true);
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(Step(plans).has_value());
  EXPECT_EQ(planner.requests.size(), 2u);
  EXPECT_FALSE(plans.next_leg().has_value());
}

TEST(JoinLeg, GoesOnFromWhereTheRobotIs) {
  const std::vector<core::LevelPose> path = {
      PoseAtPoint(1, 2), PoseAtPoint(3, 2), PoseAtPoint(4, 2)};
  const planning::PlanResult leg =
      FakePlannerWorker::Straight(PoseAtPoint(4, 2), PoseAtPoint(4, 6));
  const planning::PlanResult joined = JoinLeg(path, PoseAtPoint(3.1, 2), leg);
  ASSERT_EQ(joined.path.size(), 3u);
  EXPECT_EQ(joined.path[0].map_from_base.translation.x, 3);
  EXPECT_EQ(joined.path[1].map_from_base.translation.x, 4);
  EXPECT_EQ(joined.path[2].map_from_base.translation.y, 6);
  EXPECT_DOUBLE_EQ(joined.length_m, 5);
  // There already.
  EXPECT_EQ(JoinLeg(path, PoseAtPoint(4, 2), leg).path.size(), 2u);
}

}  // namespace
}  // namespace treeline::behavior
