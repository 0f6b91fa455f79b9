#include "nav_agent/behavior/maneuver.h"

#include "gtest/gtest.h"
#include "nav_agent/behavior/progress_checker.h"
#include "nav_agent/behavior/testing_devices.h"
#include "nav_agent/behavior/testing_parts.h"

namespace treeline::behavior {
namespace {

constexpr NavigatorLimits kLimits;
constexpr double kStep_s = 0.025;

class ManeuverTest : public testing::Test {
 protected:
  // Until it ends, with the robot doing what it is told, or `share` of it.
  RecoveryBehaviorOutcome Run(RecoveryBehaviorKind kind, double share = 1,
                              double wait_s = 3) {
    RecoveryBehavior maneuver(
        {.kind = kind, .wait_s = wait_s, .is_bold = is_bold}, kLimits,
        clock.Now());
    begun = clock.Now();
    while (true) {
      const RecoveryBehavior::Result result =
          maneuver.Step(pose, clock.Now(), controller);
      if (result.outcome != RecoveryBehaviorOutcome::kRunning)
        return result.outcome;
      geometry::Rigid2& here = pose.pose.map_from_base;
      here = here *
             geometry::Rigid2{{share * kStep_s * result.command.forward_mps, 0},
                              share * kStep_s * result.command.yaw_rate_radps};
      clock.Advance_s(kStep_s);
    }
  }
  double Took_s() const {
    return std::chrono::duration<double>(clock.Now() - begun).count();
  }

  ManualClock clock;
  base::MonotonicTime begun;
  FakeController controller;
  control::ControlPose pose;
  bool is_bold = false;
};

// Behind the robot no sensor looks.
TEST_F(ManeuverTest, BacksUpAmongPeopleOnlyIfLittleElseIsLeft) {
  controller.quiet_s = 3;
  EXPECT_EQ(Run(RecoveryBehaviorKind::kBackUp),
            RecoveryBehaviorOutcome::kNotPossible);
  EXPECT_LT(Took_s(), 0.1);
  EXPECT_EQ(pose.pose.map_from_base.translation.x, 0);
  is_bold = true;
  EXPECT_EQ(Run(RecoveryBehaviorKind::kBackUp), RecoveryBehaviorOutcome::kDone);
  EXPECT_LT(pose.pose.map_from_base.translation.x, -0.2);
}

TEST_F(ManeuverTest, TheBoldWaitForAQuietMomentAndStandWhenSomebodyComes) {
  is_bold = true;
  controller.quiet_s = 0.5;
  EXPECT_EQ(Run(RecoveryBehaviorKind::kBackUp),
            RecoveryBehaviorOutcome::kNotPossible);
  EXPECT_NEAR(Took_s(), kLimits.back_up_s, 0.1);
  EXPECT_EQ(pose.pose.map_from_base.translation.x, 0);

  controller.quiet_s = 2;
  RecoveryBehavior maneuver(
      {.kind = RecoveryBehaviorKind::kBackUp, .is_bold = true}, kLimits,
      clock.Now());
  EXPECT_LT(maneuver.Step(pose, clock.Now(), controller).command.forward_mps,
            0);
  controller.quiet_s = 0;
  EXPECT_EQ(maneuver.Step(pose, clock.Now(), controller).outcome,
            RecoveryBehaviorOutcome::kTimedOut);
}

TEST_F(ManeuverTest, BacksUpAsFarAsItMay) {
  EXPECT_EQ(Run(RecoveryBehaviorKind::kBackUp), RecoveryBehaviorOutcome::kDone);
  EXPECT_NEAR(pose.pose.map_from_base.translation.x, -kLimits.back_up_m, 0.03);
}

TEST_F(ManeuverTest, BacksUpAsFarAsThereIsRoom) {
  controller.free_m = 0.15;
  EXPECT_EQ(Run(RecoveryBehaviorKind::kBackUp), RecoveryBehaviorOutcome::kDone);
  EXPECT_GT(pose.pose.map_from_base.translation.x, -0.15);
  controller.free_m = 0.05;
  EXPECT_EQ(Run(RecoveryBehaviorKind::kBackUp),
            RecoveryBehaviorOutcome::kNotPossible);
}

TEST_F(ManeuverTest, BackingUpEndsWhenSomethingHoldsTheRobot) {
  EXPECT_EQ(Run(RecoveryBehaviorKind::kBackUp, 0.1),
            RecoveryBehaviorOutcome::kTimedOut);
  EXPECT_LT(Took_s(), kLimits.back_up_s + 0.1);
}

TEST_F(ManeuverTest, LooksAllAround) {
  EXPECT_EQ(Run(RecoveryBehaviorKind::kLookAround),
            RecoveryBehaviorOutcome::kDone);
  EXPECT_LT(Took_s(), 2 * M_PI / kLimits.look_radps + 0.1);
  EXPECT_GT(Took_s(), 0.9 * 2 * M_PI / kLimits.look_radps);
  EXPECT_EQ(Run(RecoveryBehaviorKind::kLookAround, 0.3),
            RecoveryBehaviorOutcome::kTimedOut);
  controller.can_turn = false;
  EXPECT_EQ(Run(RecoveryBehaviorKind::kLookAround),
            RecoveryBehaviorOutcome::kNotPossible);
}

// Slopes have edges.
TEST_F(ManeuverTest, DoesNotTurnOnASlope) {
  pose.level_from_base = geometry::Rotation3::FromAxisAngle({0, 0.1, 0});
  EXPECT_EQ(Run(RecoveryBehaviorKind::kLookAround),
            RecoveryBehaviorOutcome::kNotPossible);
}

TEST_F(ManeuverTest, WaitsAndClears) {
  EXPECT_EQ(Run(RecoveryBehaviorKind::kWait, 1, 5),
            RecoveryBehaviorOutcome::kDone);
  EXPECT_NEAR(Took_s(), 5, 0.05);
  EXPECT_EQ(Run(RecoveryBehaviorKind::kClearCostmap),
            RecoveryBehaviorOutcome::kDone);
  EXPECT_EQ(controller.clears, 1);
}

TEST(RecoverySequence, EndsAndIsRefilled) {
  RecoverySequence ladder(kLimits);
  double last_wait_s = 0;
  for (int i = 0; i < kLimits.max_recoveries; ++i) {
    const std::optional<RecoverySequenceStep> rung =
        ladder.Next(Trouble::kNoWay);
    ASSERT_TRUE(rung.has_value());
    EXPECT_GE(rung->wait_s, last_wait_s);
    EXPECT_LE(rung->wait_s, kLimits.longest_wait_s);
    last_wait_s = rung->wait_s;
    EXPECT_EQ(rung->is_bold, i >= 4);
  }
  EXPECT_FALSE(ladder.Next(Trouble::kStuck).has_value());
  ladder.Refill();
  EXPECT_TRUE(ladder.Next(Trouble::kStuck).has_value());
}

TEST(RecoverySequence, BeforeAnOccupiedGoalItStands) {
  RecoverySequence ladder(kLimits);
  int waits = 0;
  for (int i = 0; i < kLimits.max_recoveries; ++i) {
    const std::optional<RecoverySequenceStep> rung =
        ladder.Next(Trouble::kOccupied);
    ASSERT_TRUE(rung.has_value());
    const bool is_wait = rung->kind == RecoveryBehaviorKind::kWait;
    EXPECT_TRUE(is_wait || rung->kind == RecoveryBehaviorKind::kClearCostmap);
    waits += is_wait ? 1 : 0;
  }
  EXPECT_GT(waits, kLimits.max_recoveries / 2);
  EXPECT_FALSE(ladder.Next(Trouble::kOccupied).has_value());
}

TEST(ProgressChecker, WantsLessToGoInTime) {
  ManualClock clock;
  ProgressChecker watch(kLimits);
  EXPECT_TRUE(watch.Observe(clock.Now(), 0, 5, 0));
  clock.Advance_s(kLimits.progress_s - 0.1);
  EXPECT_TRUE(watch.Observe(clock.Now(), 0, 5 - kLimits.progress_m, 0));
  clock.Advance_s(kLimits.progress_s - 0.1);
  EXPECT_TRUE(watch.Observe(clock.Now(), 0, 4.8, 0));
  clock.Advance_s(0.2);
  EXPECT_FALSE(watch.Observe(clock.Now(), 0, 4.8, 0));
}

TEST(ProgressChecker, ATurnCountsOnceAndToAndFroDoesNot) {
  ManualClock clock;
  ProgressChecker watch(kLimits);
  EXPECT_TRUE(watch.Observe(clock.Now(), 0, 5, 0));
  bool gets_on = true;
  double seconds = 0;
  for (int i = 0; gets_on && i < 1000; ++i) {
    clock.Advance_s(1);
    seconds += 1;
    gets_on = watch.Observe(clock.Now(), 0, i % 2 == 0 ? 5.2 : 5.0,
                            i % 2 == 0 ? 0.6 : 0);
  }
  EXPECT_FALSE(gets_on);
  EXPECT_LE(seconds, 2 * kLimits.progress_s + 2);
}

// Going away and coming back refills nothing.
TEST(ProgressChecker, RefillsOnlyNearerThanEver) {
  ManualClock clock;
  ProgressChecker watch(kLimits);
  int refills = 0;
  for (int round = 0; round < 5; ++round) {
    for (double to_go_m = 10; to_go_m > 5; to_go_m -= 0.1) {
      watch.Observe(clock.Now(), 0, to_go_m, 0);
      refills += watch.TakeRefill() ? 1 : 0;
    }
  }
  EXPECT_GE(refills, 4);
  EXPECT_LE(refills, 5);
  watch.Observe(clock.Now(), 1, 10, 0);
  EXPECT_TRUE(watch.TakeRefill());
}

}  // namespace
}  // namespace treeline::behavior
