#include "nav_agent/drivers/segway/turn_watch.h"

#include <chrono>

#include "gtest/gtest.h"

namespace treeline::segway {
namespace {

using Verdict = TurnWatch::Verdict;
constexpr double kTrack_m = 0.5;

class TurnWatchTest : public ::testing::Test {
 protected:
  // Asks for one turn while the base makes another.
  void Run(double asked_radps, double made_radps, int ms) {
    for (int i = 0; i < ms; i += 10) {
      now_ += std::chrono::milliseconds(10);
      watch_.Sent(asked_radps, now_);
      reading_.left_wheel_m += 0.01 * (0.3 - 0.5 * kTrack_m * made_radps);
      reading_.right_wheel_m += 0.01 * (0.3 + 0.5 * kTrack_m * made_radps);
      watch_.Take(reading_, now_);
    }
  }

  TurnWatch watch_{kTrack_m};
  base::MonotonicTime now_;
  core::BaseReading reading_;
};

TEST_F(TurnWatchTest, ATurnThatIsMadeIsRightForGood) {
  Run(0.5, 0.5, 690);
  EXPECT_EQ(watch_.verdict(), Verdict::kUndecided);
  Run(0.5, 0.5, 40);
  EXPECT_EQ(watch_.verdict(), Verdict::kRight);
  Run(0.5, -0.5, 5000);  // someone has pushed it
  EXPECT_EQ(watch_.verdict(), Verdict::kRight);
}

TEST_F(TurnWatchTest, TheOtherWayIsWrong) {
  Run(-0.5, 0.5, 730);
  EXPECT_EQ(watch_.verdict(), Verdict::kWrong);
}

TEST_F(TurnWatchTest, StraightOrSlowOrStuckDecidesNothing) {
  Run(0, -0.5, 5000);
  Run(0.09, -0.5, 5000);
  Run(0.5, 0, 5000);
  EXPECT_EQ(watch_.verdict(), Verdict::kUndecided);
}

// The base is still turning left when right is asked for.
TEST_F(TurnWatchTest, WhatItTakesToFollowDoesNotCount) {
  for (int i = 0; i < 20; ++i) {
    Run(-0.8, 0.8, 450);
    Run(0.8, -0.8, 450);
  }
  EXPECT_EQ(watch_.verdict(), Verdict::kUndecided);
}

}  // namespace
}  // namespace treeline::segway
