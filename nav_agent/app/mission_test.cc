// The whole loop: a navigator drives a simulated robot to its goals.
#include <cmath>

#include "gtest/gtest.h"
#include "nav_agent/app/testing_mission.h"

namespace treeline {
namespace {

TEST(Mission, DrivesToAGoal) {
  TestMission mission({});
  mission.Send({mission.At(9.2, 7.9)});
  const GoalStatus goal = mission.RunToEnd(60);
  EXPECT_EQ(goal.state, GoalState::kSucceeded) << mission.Story();
  EXPECT_LT(Norm(mission.Truth().translation - Vec2{9.2, 7.9}), 0.25);
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
  if (std::getenv("STORY")) std::puts(mission.Story().c_str());
}

TEST(Mission, DrivesUpTheSlope) {
  TestMission mission({});
  mission.Send({mission.Near(10.2, 2.0, 0, 0.4)});
  const GoalStatus goal = mission.RunToEnd(90);
  EXPECT_EQ(goal.state, GoalState::kSucceeded) << mission.Story();
  EXPECT_TRUE(mission.mishaps().empty()) << mission.Story();
  if (std::getenv("STORY")) std::puts(mission.Story().c_str());
}

}  // namespace
}  // namespace treeline
