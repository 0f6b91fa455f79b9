#include "nav_agent/behavior/arrival_check.h"

#include "gtest/gtest.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/testing_devices.h"
#include "nav_agent/behavior/testing_parts.h"

namespace treeline::behavior {
namespace {

class ArrivalCheckTest : public testing::Test {
 protected:
  using Outcome = ArrivalCheck::Outcome;

  ArrivalCheckTest() { robot.pose = target; }

  Outcome Step(double after_s = 0) {
    clock.Advance_s(after_s);
    return check.Step(robot, target, tolerances, clock.Now());
  }

  ManualClock clock;
  control::LocalControllerOptions tolerances;
  core::LevelPose target = PoseAtPoint(5, 2);
  control::ControlPose robot;
  ArrivalCheck check{PathEnd()};
};

TEST_F(ArrivalCheckTest, IsReachedWithinToleranceAndStanding) {
  EXPECT_EQ(Step(), Outcome::kReached);
  robot.forward_mps = 2 * control::kStandingSpeed_mps;
  EXPECT_EQ(Step(), Outcome::kOpen);
  robot.forward_mps = 0;
  robot.yaw_rate_radps = -2 * control::kStandingTurn_radps;
  EXPECT_EQ(Step(), Outcome::kOpen);
  robot.yaw_rate_radps = 0;
  robot.pose = PoseAtPoint(5 - tolerances.goal_tolerance_m - 0.05, 2);
  EXPECT_EQ(Step(), Outcome::kOpen);
  robot.pose = PoseAtPoint(5, 2, -tolerances.goal_tolerance_rad - 0.05);
  EXPECT_EQ(Step(), Outcome::kOpen);
  robot.pose = PoseAtPoint(5 - tolerances.goal_tolerance_m, 2,
                           -tolerances.goal_tolerance_rad);
  EXPECT_EQ(Step(), Outcome::kReached);
}

TEST_F(ArrivalCheckTest, AControllerThatIsWrongIsDisputed) {
  robot.pose = PoseAtPoint(4, 2);
  EXPECT_EQ(Step(), Outcome::kOpen);
  EXPECT_EQ(Step(kArrivalDispute_s - 0.1), Outcome::kOpen);
  EXPECT_EQ(Step(0.2), Outcome::kDisputed);
  check.Restart();
  EXPECT_EQ(Step(), Outcome::kOpen);
}

TEST_F(ArrivalCheckTest, WaitsBesideAGoalThatIsTaken) {
  check = ArrivalCheck({.beside_goal_m = 0.6, .is_goal_taken = true});
  EXPECT_EQ(Step(), Outcome::kStands);
  EXPECT_EQ(Step(kGoalWait_s - 0.1), Outcome::kStands);
  EXPECT_EQ(Step(0.2), Outcome::kReached);
  // Where the map has no room, nothing is waited for.
  check = ArrivalCheck({.beside_goal_m = 0.6, .is_goal_taken = false});
  EXPECT_EQ(Step(), Outcome::kReached);
}

TEST_F(ArrivalCheckTest, SaysHowFarOffItIs) {
  const core::LevelPose off = PoseAtPoint(4.97, 2.04, 0.1);
  EXPECT_EQ(check.Text(off, target, 12.34),
            "0.05 m and 6 degrees off, after 12.3 m");
  check = ArrivalCheck({.beside_goal_m = 0.6, .is_goal_taken = true});
  EXPECT_EQ(check.Text(target, target, 1),
            "0.00 m and 0 degrees off, after 1.0 m, at a place 0.60 m beside "
            "the goal, where something stands");
  check = ArrivalCheck({.beside_goal_m = 0.6, .is_goal_taken = false});
  EXPECT_EQ(check.Text(target, target, 1),
            "0.00 m and 0 degrees off, after 1.0 m, at a place 0.60 m beside "
            "the goal, which has no room");
}

}  // namespace
}  // namespace treeline::behavior
