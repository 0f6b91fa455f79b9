#include "nav_agent/behavior/recovering_state.h"

#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/testing_goal.h"

namespace treeline::behavior {
namespace {

class RecoveringStateTest : public GoalFixture {
 protected:
  using Outcome = RecoveringState::Outcome;

  static RecoveringState From(Trouble kind) {
    return RecoveringState({.kind = kind,
                            .cause = core::NavigationCause::kBlocked,
                            .why = "a chair"});
  }
  Outcome Step(RecoveringState& recovering, double after_s = 0) {
    clock.Advance_s(after_s);
    return recovering.Step(robot, tools, Now()).outcome;
  }

  control::ControlPose robot = Robot(1, 2);
};

TEST_F(RecoveringStateTest, WaitsFirstWhereThereIsNoWay) {
  RecoveringState recovering = From(Trouble::kNoWay);
  ASSERT_TRUE(recovering.BeginNext(tools, Now()));
  EXPECT_TRUE(Said("recovery", "wait (blocked: a chair)"));
  EXPECT_EQ(Step(recovering, kFirstWait_s - 0.1), Outcome::kRuns);
  EXPECT_EQ(Step(recovering, 0.2), Outcome::kDone);
  EXPECT_TRUE(Said("recovery", "wait: done"));
}

TEST_F(RecoveringStateTest, DoesNotWaitForWhatIsGone) {
  RecoveringState recovering = From(Trouble::kNoWay);
  ASSERT_TRUE(recovering.BeginNext(tools, Now()));
  recovering.NoteWayIsFree();
  EXPECT_EQ(Step(recovering, kMinWait_s - 0.1), Outcome::kRuns);
  EXPECT_EQ(Step(recovering, 0.2), Outcome::kDone);
  // That did not count.
  EXPECT_EQ(tools.attempts.recoveries().used(), 0);
}

TEST_F(RecoveringStateTest, WhatIsImpossibleIsFollowedByTheNext) {
  RecoveringState recovering = From(Trouble::kStuck);
  ASSERT_TRUE(recovering.BeginNext(tools, Now()));
  EXPECT_EQ(Step(recovering), Outcome::kDone);
  EXPECT_EQ(controller.clears, 1);
  controller.free_m = 0;
  ASSERT_TRUE(recovering.BeginNext(tools, Now()));
  EXPECT_EQ(Step(recovering), Outcome::kNotPossible);
  ASSERT_TRUE(recovering.BeginNext(tools, Now()));
  EXPECT_TRUE(Said("recovery", "re-route"));
}

TEST_F(RecoveringStateTest, WhatIsImpossibleDoesNotMatterIfTheWayIsFree) {
  RecoveringState recovering = From(Trouble::kStuck);
  ASSERT_TRUE(recovering.BeginNext(tools, Now()));
  controller.free_m = 0;
  ASSERT_TRUE(recovering.BeginNext(tools, Now()));
  recovering.NoteWayIsFree();
  EXPECT_EQ(Step(recovering), Outcome::kDone);
  EXPECT_TRUE(Said("recovery", "back up: not possible"));
}

TEST_F(RecoveringStateTest, ToReRouteBlocksWhatIsAhead) {
  RecoveringState recovering = From(Trouble::kStuck);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(recovering.BeginNext(tools, Now()));
  EXPECT_EQ(Step(recovering), Outcome::kDone);
  const std::vector<planning::Blockage> known = tools.blockages.All();
  ASSERT_EQ(known.size(), 1u);
  EXPECT_EQ(known[0].center.x, 1 + kRerouteAhead_m);
  EXPECT_EQ(known[0].radius_m, kRerouteRadius_m);
}

TEST_F(RecoveringStateTest, EndsWithTheBudget) {
  RecoveringState recovering = From(Trouble::kStuck);
  for (int i = 0; i < options.limits.max_recoveries; ++i) {
    EXPECT_TRUE(recovering.BeginNext(tools, Now()));
  }
  EXPECT_FALSE(recovering.BeginNext(tools, Now()));
  EXPECT_EQ(recovering.trouble().why, "a chair");
}

}  // namespace
}  // namespace treeline::behavior
