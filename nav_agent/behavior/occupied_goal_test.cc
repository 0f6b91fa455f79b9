#include "nav_agent/behavior/occupied_goal.h"

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_devices.h"

namespace treeline::behavior {
namespace {

TEST(OccupiedGoal, IsTriedAfterWaitsThatGrowUntilThereIsNoTime) {
  ManualClock clock;
  OccupiedGoal occupied;
  EXPECT_TRUE(occupied.MayTry(clock.Now()));
  double waited_s = 0;
  int met = 0;
  double last_wait_s = 0;
  while (occupied.Meet(clock.Now())) {
    ++met;
    double wait_s = 0;
    while (!occupied.MayTry(clock.Now())) {
      clock.Advance_s(0.5);
      wait_s += 0.5;
      ASSERT_LT(wait_s, 60);
    }
    EXPECT_GT(wait_s, last_wait_s);
    last_wait_s = wait_s;
    waited_s += wait_s;
  }
  EXPECT_EQ(met, 2);
  EXPECT_LE(waited_s, kGoalWait_s);
  // Never again.
  clock.Advance_s(1000);
  EXPECT_FALSE(occupied.MayTry(clock.Now()));
  EXPECT_FALSE(occupied.Meet(clock.Now()));
  occupied.Reset();
  EXPECT_TRUE(occupied.MayTry(clock.Now()));
  EXPECT_TRUE(occupied.Meet(clock.Now()));
}

TEST(OccupiedGoal, WhereThereIsNoRoomBesideItWaitsOnce) {
  ManualClock clock;
  OccupiedGoal occupied;
  EXPECT_FALSE(occupied.HasWaited(clock.Now()));
  clock.Advance_s(kBlockageMemory_s - 0.1);
  occupied.Meet(clock.Now());
  EXPECT_FALSE(occupied.HasWaited(clock.Now()));
  clock.Advance_s(0.2);
  EXPECT_TRUE(occupied.HasWaited(clock.Now()));
  occupied.Reset();
  EXPECT_FALSE(occupied.HasWaited(clock.Now()));
}

TEST(OccupiedGoal, TellsPeopleOnce) {
  OccupiedGoal occupied;
  EXPECT_TRUE(occupied.TellOnce());
  EXPECT_FALSE(occupied.TellOnce());
  occupied.Reset();
  EXPECT_TRUE(occupied.TellOnce());
}

}  // namespace
}  // namespace treeline::behavior
