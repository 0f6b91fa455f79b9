#include "nav_agent/drivers/segway/velocity_limits.h"

#include <cmath>
#include <limits>

#include "gtest/gtest.h"

namespace treeline::segway {
namespace {

constexpr VelocityLimits kLimits = {};

TEST(VelocityLimits, WhatIsWithinStays) {
  const core::VelocityCommand command = {.forward_mps = 0.5,
                                         .yaw_rate_radps = -1};
  EXPECT_EQ(Limited(command, kLimits), command);
}

TEST(VelocityLimits, WhatIsBeyondKeepsItsArc) {
  const core::VelocityCommand fast =
      Limited({.forward_mps = 1.6, .yaw_rate_radps = 1.0}, kLimits);
  EXPECT_DOUBLE_EQ(fast.forward_mps, 0.8);
  EXPECT_DOUBLE_EQ(fast.yaw_rate_radps, 0.5);
  const core::VelocityCommand backward =
      Limited({.forward_mps = -0.6, .yaw_rate_radps = 1.0}, kLimits);
  EXPECT_DOUBLE_EQ(backward.forward_mps, -0.3);
  EXPECT_DOUBLE_EQ(backward.yaw_rate_radps, 0.5);
  const core::VelocityCommand turning =
      Limited({.forward_mps = 0.8, .yaw_rate_radps = -3.0}, kLimits);
  EXPECT_DOUBLE_EQ(turning.forward_mps, 0.4);
  EXPECT_DOUBLE_EQ(turning.yaw_rate_radps, -1.5);
}

TEST(VelocityLimits, SpeedsUpAndSlowsDownNoFasterThanAllowed) {
  const core::VelocityCommand target = {.forward_mps = 0.8,
                                        .yaw_rate_radps = 1.5};
  core::VelocityCommand command;
  command = Approach(command, target, kLimits, 0.1);
  EXPECT_DOUBLE_EQ(command.forward_mps, 0.08);
  EXPECT_DOUBLE_EQ(command.yaw_rate_radps, 0.3);
  for (int i = 0; i < 20; ++i) {
    command = Approach(command, target, kLimits, 0.1);
  }
  EXPECT_EQ(command, target);
  command = Approach(command, {}, kLimits, 0.1);
  EXPECT_NEAR(command.forward_mps, 0.65, 1e-12);
  for (int i = 0; i < 20; ++i) command = Approach(command, {}, kLimits, 0.1);
  EXPECT_EQ(command, core::VelocityCommand{});
}

TEST(VelocityLimits, ReversesThroughStandstill) {
  const core::VelocityCommand target = {.forward_mps = -0.3,
                                        .yaw_rate_radps = 0};
  core::VelocityCommand command = {.forward_mps = 0.1, .yaw_rate_radps = 0};
  command = Approach(command, target, kLimits, 0.1);
  EXPECT_EQ(command.forward_mps, 0);
  command = Approach(command, target, kLimits, 0.1);
  EXPECT_DOUBLE_EQ(command.forward_mps, -0.08);
}

TEST(VelocityLimits, LimitsThatAreNoneAreRefused) {
  EXPECT_TRUE(kLimits.Validate().ok());
  for (const double bad :
       {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    VelocityLimits limits;
    limits.max_deceleration_mps2 = bad;
    EXPECT_EQ(limits.Validate().code(), absl::StatusCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace treeline::segway
