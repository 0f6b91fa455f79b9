#include "nav_agent/behavior/operator_control.h"

#include <limits>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_devices.h"

namespace treeline::behavior {
namespace {

using ::testing::HasSubstr;

class OperatorControlTest : public ::testing::Test {
 protected:
  OperatorControlTest() { events_.SetTime(clock_.Now()); }

  std::vector<std::string> Kinds() {
    std::vector<std::string> kinds;
    for (const NavigatorEvent& event : events_.Take()) {
      kinds.push_back(event.kind);
    }
    return kinds;
  }

  ManualClock clock_;
  EventLog events_;
  LatchedStop stop_{events_};
  ManualDrive manual_{events_};
};

TEST_F(OperatorControlTest, AStopHoldsWithItsFirstReasonUntilItIsReleased) {
  EXPECT_TRUE(stop_.Refuse("the goal").ok());
  EXPECT_TRUE(stop_.Hold("a child", clock_.Now()));
  clock_.Advance_s(1000);
  EXPECT_FALSE(stop_.Hold("a dog", clock_.Now()));
  const absl::Status refused = stop_.Refuse("the goal");
  EXPECT_EQ(refused.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(refused.message()), HasSubstr("the goal is refused"));
  EXPECT_THAT(std::string(refused.message()), HasSubstr("a child"));
  EXPECT_TRUE(stop_.Release(clock_.Now()));
  EXPECT_FALSE(stop_.Release(clock_.Now()));
  EXPECT_TRUE(stop_.Refuse("the goal").ok());
  EXPECT_THAT(Kinds(), ::testing::ElementsAre("stop", "release"));
}

TEST_F(OperatorControlTest, MotionEndsWithoutAFreshCommand) {
  EXPECT_FALSE(manual_.Wanted(clock_.Now()).has_value());
  const core::VelocityCommand ahead = {.forward_mps = 0.3,
                                       .yaw_rate_radps = 0.1};
  ASSERT_TRUE(manual_.Drive(ahead, clock_.Now()).ok());
  clock_.Advance_s(0.29);
  EXPECT_EQ(manual_.Wanted(clock_.Now()), ahead);
  ASSERT_TRUE(manual_.Drive(ahead, clock_.Now()).ok());
  clock_.Advance_s(0.29);
  EXPECT_EQ(manual_.Wanted(clock_.Now()), ahead);
  clock_.Advance_s(0.02);
  EXPECT_FALSE(manual_.Wanted(clock_.Now()).has_value());
  EXPECT_FALSE(manual_.is_active());
  EXPECT_THAT(Kinds(), ::testing::ElementsAre("manual", "manual"));
}

// A clock that runs four times as fast as that of whoever drives.
TEST_F(OperatorControlTest, ALeaseIsAsLongAsItIsTold) {
  ManualDrive fast(events_, 4 * kManualLease_s);
  const core::VelocityCommand ahead = {.forward_mps = 0.3, .yaw_rate_radps = 0};
  ASSERT_TRUE(fast.Drive(ahead, clock_.Now()).ok());
  clock_.Advance_s(1.19);
  EXPECT_EQ(fast.Wanted(clock_.Now()), ahead);
  clock_.Advance_s(0.02);
  EXPECT_FALSE(fast.Wanted(clock_.Now()).has_value());
}

TEST_F(OperatorControlTest, WhatIsNotFiniteIsNotDriven) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(
      manual_.Drive({.forward_mps = nan, .yaw_rate_radps = 0}, clock_.Now())
          .ok());
  EXPECT_FALSE(manual_.is_active());
}

}  // namespace
}  // namespace treeline::behavior
