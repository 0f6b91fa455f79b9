#include "nav_agent/behavior/swing_motion.h"

#include <algorithm>
#include <numbers>

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {
namespace {

TEST(TurnTowards, TakesTheShorterWayAndSlowsDown) {
  localization::TrackedMotion motion;
  EXPECT_DOUBLE_EQ(TurnTowards(1, motion, 0.8).yaw_rate_radps, 0.8);
  EXPECT_DOUBLE_EQ(TurnTowards(-1, motion, 0.8).yaw_rate_radps, -0.8);
  EXPECT_DOUBLE_EQ(TurnTowards(0.2, motion, 0.8).yaw_rate_radps, 0.4);
  EXPECT_DOUBLE_EQ(TurnTowards(0.01, motion, 0.8).yaw_rate_radps, 0.12);
  motion.odom_from_base.yaw_rad = 3;
  EXPECT_NEAR(TurnTowards(-3, motion, 0.8).yaw_rate_radps,
              2 * (2 * std::numbers::pi - 6), 1e-9);
  EXPECT_EQ(TurnTowards(-3, motion, 0.8).forward_mps, 0);
}

// A robot that turns between two headings and no further.
class SwingMotionTest : public testing::Test {
 protected:
  void Step() {
    now_s_ += kStep_s;
    left_rad_ += kStep_s * gives_way_radps_;
    const core::VelocityCommand wanted = swing_.Step(
        motion_, {.now = At(now_s_), .free_ahead_m = free_ahead_m_}, 0.8, 0.15);
    const double yaw_rad = motion_.odom_from_base.yaw_rad;
    const double turned_rad = std::clamp(
        yaw_rad + kStep_s * wanted.yaw_rate_radps, right_rad_, left_rad_);
    motion_.yaw_rate_radps = (turned_rad - yaw_rad) / kStep_s;
    motion_.odom_from_base.yaw_rad = turned_rad;
    moved_m_ += kStep_s * wanted.forward_mps;
    held_steps_ += turned_rad == yaw_rad ? 1 : 0;
    highest_rad_ = std::max(highest_rad_, turned_rad);
    lowest_rad_ = std::min(lowest_rad_, turned_rad);
  }
  void Run(double seconds) {
    for (double s = 0; s < seconds; s += kStep_s) Step();
  }

  SwingMotion swing_;
  localization::TrackedMotion motion_;
  double now_s_ = 100;
  double free_ahead_m_ = 0;
  double right_rad_ = -1e9;
  double left_rad_ = 1e9;
  // What holds it to the left moves on.
  double gives_way_radps_ = 0;
  double moved_m_ = 0;
  int held_steps_ = 0;
  double highest_rad_ = 0;
  double lowest_rad_ = 0;
};

TEST_F(SwingMotionTest, TurnsOnWhereNothingHoldsIt) {
  Run(10);
  EXPECT_NEAR(highest_rad_, 8, 0.1);
  EXPECT_EQ(lowest_rad_, 0);
}

TEST_F(SwingMotionTest, SwingsBackWhereItIsHeld) {
  right_rad_ = -1;
  left_rad_ = 0.5;
  Run(10);
  EXPECT_EQ(highest_rad_, 0.5);
  EXPECT_EQ(lowest_rad_, -1);
}

TEST_F(SwingMotionTest, WhoCreepsAlongSomethingIsHeldByIt) {
  right_rad_ = -1;
  left_rad_ = 0.5;
  gives_way_radps_ = 0.03;
  Run(5);
  EXPECT_LT(highest_rad_, 0.6);
  EXPECT_EQ(lowest_rad_, -1);
}

TEST_F(SwingMotionTest, IsHeldOncePerSide) {
  right_rad_ = -1;
  left_rad_ = 0.5;
  Run(20);
  const int held_steps = held_steps_;
  Run(20);
  EXPECT_EQ(held_steps_, held_steps);
  // After a recovery it may try again.
  swing_.ForgetHeld();
  Run(20);
  EXPECT_GT(held_steps_, held_steps);
}

TEST_F(SwingMotionTest, GoesAheadWhereItTurnsToNeitherSide) {
  right_rad_ = 0;
  left_rad_ = 0;
  free_ahead_m_ = 1;
  Run(1.2);
  EXPECT_EQ(moved_m_, 0);
  Run(2);
  EXPECT_GT(moved_m_, 0.1);
}

TEST_F(SwingMotionTest, DoesNotGoAheadWithoutRoom) {
  right_rad_ = 0;
  left_rad_ = 0;
  free_ahead_m_ = 0.2;
  Run(20);
  EXPECT_EQ(moved_m_, 0);
}

}  // namespace
}  // namespace treeline::behavior
