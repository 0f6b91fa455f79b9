#include "nav_agent/behavior/goal_attempts.h"

#include "gtest/gtest.h"

namespace treeline::behavior {
namespace {

TEST(GoalAttempts, AreAllThereAgainOnceTheRobotGotOn) {
  NavigatorLimits limits;
  limits.max_replans = 2;
  limits.max_recoveries = 1;
  GoalAttempts attempts(limits);
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(attempts.TakeReplan());
    EXPECT_TRUE(attempts.TakeReplan());
    EXPECT_FALSE(attempts.TakeReplan());
    EXPECT_FALSE(attempts.TakeReplan());
    EXPECT_TRUE(attempts.recoveries().Next(Trouble::kStuck).has_value());
    EXPECT_FALSE(attempts.recoveries().Next(Trouble::kStuck).has_value());
    attempts.Refill();
  }
}

}  // namespace
}  // namespace treeline::behavior
