// Lost and found with the real tracker, in the simulator.
#include "gtest/gtest.h"
#include "tests/robot/testing_lost_robot.h"

namespace treeline {
namespace {

TEST(LostAndFoundInTheLab, AKidnappedRobotFindsItsPlaceInSeconds) {
  LostRobot robot(LostPlaceOf("lab"), 1001, true, {});
  robot.TellTruth();
  for (int i = 0; i < 80; ++i) robot.Step();
  ASSERT_TRUE(robot.CarryAway(1001));
  EXPECT_EQ(robot.StepUntilDone(10), behavior::RelocalizationState::kFound);
  EXPECT_TRUE(robot.IsRight()) << robot.Error_m() << " m";
  EXPECT_EQ(robot.server().asked, 1);
}

TEST(LostAndFoundInTheLab, AConfidentWrongServerIsNeverBelieved) {
  behavior::RelocalizationBehaviorOptions options;
  options.max_questions = 4;
  options.max_search_s = 0;
  LostRobot robot(LostPlaceOf("lab"), 1002, false, options);
  robot.TellTruth();
  for (int i = 0; i < 80; ++i) robot.Step();
  const geometry::Rigid3 before = robot.simulator().state().world_from_base;
  ASSERT_TRUE(robot.CarryAway(1002));
  // Where it was before: upright, on free ground, in the right scene.
  robot.server().answers = [&](const core::RgbdFrame& frame) {
    return robot.AnswerFor(before, frame, 0.99);
  };
  EXPECT_EQ(robot.StepUntilDone(60), behavior::RelocalizationState::kNeedHelp);
}

}  // namespace
}  // namespace treeline
