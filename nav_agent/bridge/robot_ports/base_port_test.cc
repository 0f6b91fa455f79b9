#include "nav_agent/bridge/robot_ports/base_port.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <vector>

#include "nav_agent/bridge/robot_ports/testing_ports.h"

namespace treeline::robot_ports {
namespace {

using ::testing::HasSubstr;

class BasePortTest : public ::testing::Test {
 protected:
  static constexpr core::VelocityCommand kDrive = {.forward_mps = 0.4,
                                                   .yaw_rate_radps = -0.2};
  static constexpr core::VelocityCommand kStand = {};

  ManualClock real_;
  std::vector<core::VelocityCommand> sent_;
  int listeners_ = 1;
  absl::Status write_;
  absl::Status obstacle_;
  std::unique_ptr<BasePort> port_ = std::make_unique<BasePort>(
      "cmd_vel", real_,
      BasePort::Wire{.send =
                         [this](const core::VelocityCommand& command) {
                           sent_.push_back(command);
                           return write_;
                         },
                     .listeners = [this] { return listeners_; },
                     .obstacle = [this] { return obstacle_; }});
};

TEST_F(BasePortTest, CommandsGoOutAndZerosEndAfterASecond) {
  EXPECT_TRUE(port_->SetVelocity(kStand).ok());
  EXPECT_TRUE(sent_.empty()) << "somebody else may be driving";
  EXPECT_TRUE(port_->SetVelocity(kDrive).ok());
  ASSERT_EQ(sent_.size(), 1U);
  EXPECT_EQ(sent_[0], kDrive);
  for (int i = 0; i < 200; ++i) {
    real_.Pass(0.025);
    EXPECT_TRUE(port_->SetVelocity(kStand).ok());
  }
  EXPECT_GE(sent_.size(), 40U);
  EXPECT_LE(sent_.size(), 42U);
  EXPECT_EQ(sent_.back(), kStand);
}

TEST_F(BasePortTest, ACommandThatNobodyRenewsIsEnded) {
  ASSERT_TRUE(port_->SetVelocity(kDrive).ok());
  real_.Pass(0.29);
  port_->Watch();
  EXPECT_EQ(sent_.size(), 1U);
  real_.Pass(0.02);
  port_->Watch();
  ASSERT_EQ(sent_.size(), 2U);
  EXPECT_EQ(sent_[1], kStand);
  port_->Watch();
  EXPECT_EQ(sent_.size(), 2U);
}

TEST_F(BasePortTest, WhatIsNotFiniteStops) {
  ASSERT_TRUE(port_->SetVelocity(kDrive).ok());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(port_->SetVelocity({.forward_mps = nan}).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(sent_.back(), kStand);
}

TEST_F(BasePortTest, NobodyListens) {
  listeners_ = 0;
  EXPECT_EQ(port_->SetVelocity(kDrive).code(), absl::StatusCode::kUnavailable);
  const core::DeviceHealth health = port_->Health();
  EXPECT_EQ(health.state, core::DeviceState::kLost);
  EXPECT_THAT(std::string(health.cause.message()), HasSubstr("cmd_vel"));
  listeners_ = 1;
  EXPECT_EQ(port_->Health().state, core::DeviceState::kRunning);
}

TEST_F(BasePortTest, AnObstacleStopsAndIsForgottenWhenItIsGone) {
  ASSERT_TRUE(port_->SetVelocity(kDrive).ok());
  obstacle_ = absl::UnavailableError("no time");
  EXPECT_EQ(port_->SetVelocity(kDrive), obstacle_);
  EXPECT_EQ(sent_.back(), kStand);
  EXPECT_EQ(port_->Health().cause, obstacle_);
  real_.Pass(10);
  obstacle_ = absl::OkStatus();
  EXPECT_TRUE(port_->SetVelocity(kStand).ok());
  EXPECT_EQ(port_->Health().state, core::DeviceState::kRunning);
}

TEST_F(BasePortTest, AWireThatFailsIsTriedAgain) {
  write_ = absl::UnavailableError("no network");
  EXPECT_EQ(port_->SetVelocity(kDrive), write_);
  EXPECT_EQ(port_->Health().state, core::DeviceState::kLost);
  // The robot stands while the base is lost, and later nothing more is said.
  real_.Pass(2);
  EXPECT_FALSE(port_->SetVelocity(kStand).code() ==
               absl::StatusCode::kInvalidArgument);
  real_.Pass(2);
  EXPECT_TRUE(port_->SetVelocity(kStand).ok());
  EXPECT_EQ(port_->Health().state, core::DeviceState::kRunning);
}

TEST_F(BasePortTest, TheEndIsAStop) {
  ASSERT_TRUE(port_->SetVelocity(kDrive).ok());
  port_.reset();
  EXPECT_EQ(sent_.back(), kStand);
}

}  // namespace
}  // namespace treeline::robot_ports
