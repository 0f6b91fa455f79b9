#include "nav_agent/behavior/relocalization_states.h"

#include <optional>

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {
namespace {

localization::TrackedMotion Moving(double forward_mps, double yaw_rate_radps) {
  localization::TrackedMotion motion;
  motion.forward_mps = forward_mps;
  motion.yaw_rate_radps = yaw_rate_radps;
  return motion;
}

TEST(StoppingState, WaitsUntilTheWheelsHaveStoodForSoLong) {
  StoppingState stopping(At(100));
  EXPECT_FALSE(stopping.Step(Moving(0.2, 0), 0.3, At(100)));
  EXPECT_FALSE(stopping.Step(Moving(0, 0.03), 0.3, At(100.5)));
  EXPECT_FALSE(stopping.Step(Moving(0, 0), 0.3, At(101)));
  EXPECT_FALSE(stopping.Step(Moving(0.009, 0.023), 0.3, At(101.29)));
  EXPECT_TRUE(stopping.Step(Moving(0, 0), 0.3, At(101.31)));
}

TEST(StoppingState, WhoMovesAgainWaitsAgain) {
  StoppingState stopping(At(100));
  EXPECT_FALSE(stopping.Step(Moving(0, 0), 0.3, At(100)));
  EXPECT_FALSE(stopping.Step(Moving(0.02, 0), 0.3, At(100.2)));
  EXPECT_FALSE(stopping.Step(Moving(0, 0), 0.3, At(100.4)));
  EXPECT_FALSE(stopping.Step(Moving(0, 0), 0.3, At(100.6)));
  EXPECT_TRUE(stopping.Step(Moving(0, 0), 0.3, At(100.8)));
}

TEST(StoppingState, DoesNotWaitForEver) {
  StoppingState stopping(At(100));
  EXPECT_FALSE(stopping.Step(Moving(0.2, 0), 0.3, At(104.9)));
  EXPECT_TRUE(stopping.Step(Moving(0.2, 0), 0.3, At(105)));
  StoppingState without_wheels(At(100));
  EXPECT_FALSE(without_wheels.Step(std::nullopt, 0.3, At(104)));
  EXPECT_TRUE(without_wheels.Step(std::nullopt, 0.3, At(105)));
}

TEST(LookingState, TakesAPictureOfTheRobotThatStands) {
  using Outcome = LookingState::Outcome;
  const LookingState looking(At(100));
  EXPECT_EQ(looking.Step(nullptr, At(100)), Outcome::kWaiting);
  core::RgbdFrame frame;
  frame.stamp = At(99.99);
  EXPECT_EQ(looking.Step(&frame, At(100.1)), Outcome::kWaiting);
  frame.stamp = At(100);
  EXPECT_EQ(looking.Step(&frame, At(100.1)), Outcome::kHasPicture);
}

TEST(LookingState, ASilentCameraIsNotWaitedForForEver) {
  using Outcome = LookingState::Outcome;
  const LookingState looking(At(100));
  EXPECT_EQ(looking.Step(nullptr, At(101.99)), Outcome::kWaiting);
  EXPECT_EQ(looking.Step(nullptr, At(102.01)), Outcome::kNoPictures);
  // Late is better than never.
  core::RgbdFrame frame;
  frame.stamp = At(103);
  EXPECT_EQ(looking.Step(&frame, At(103)), Outcome::kHasPicture);
}

TEST(AskingState, HasPatienceForASecond) {
  const AskingState asking(At(100));
  EXPECT_TRUE(asking.HasPatience(At(100.99)));
  EXPECT_FALSE(asking.HasPatience(At(101.01)));
}

TEST(TurningState, TurnsToItsTarget) {
  using Outcome = TurningState::Outcome;
  const TurningState turning(1, At(100));
  localization::TrackedMotion motion = Moving(0, 0);
  TurningState::Result result = turning.Step(motion, 0.8, At(100));
  EXPECT_EQ(result.outcome, Outcome::kTurns);
  EXPECT_GT(result.wanted.yaw_rate_radps, 0);
  motion.odom_from_base.yaw_rad = 0.91;
  EXPECT_EQ(turning.Step(motion, 0.8, At(101)).outcome, Outcome::kThere);
}

TEST(TurningState, WhoDoesNotBeginToTurnHasNoRoom) {
  using Outcome = TurningState::Outcome;
  const TurningState turning(1, At(100));
  EXPECT_EQ(turning.Step(Moving(0, 0), 0.8, At(101.4)).outcome,
            Outcome::kTurns);
  EXPECT_EQ(turning.Step(Moving(0, 0), 0.8, At(101.6)).outcome,
            Outcome::kNoRoom);
  EXPECT_EQ(turning.Step(Moving(0, 0.1), 0.8, At(101.6)).outcome,
            Outcome::kTurns);
}

TEST(TurningState, EndsInTime) {
  const TurningState turning(1, At(100));
  EXPECT_EQ(turning.Step(Moving(0, 0.1), 0.8, At(112.1)).outcome,
            TurningState::Outcome::kThere);
}

TEST(HelpWait, AsksNowAndThen) {
  HelpWait wait(At(100));
  EXPECT_FALSE(wait.IsTimeToAsk(15, At(114.9)));
  EXPECT_TRUE(wait.IsTimeToAsk(15, At(115)));
  wait.NoteAsked(At(115));
  EXPECT_FALSE(wait.IsTimeToAsk(15, At(129)));
  EXPECT_FALSE(wait.IsTimeToAsk(0, At(1000)));
}

TEST(IsFresh, KnowsOldPictures) {
  core::RgbdFrame frame;
  frame.stamp = At(100);
  EXPECT_TRUE(IsFresh(frame, At(100.19)));
  EXPECT_FALSE(IsFresh(frame, At(100.21)));
}

}  // namespace
}  // namespace treeline::behavior
