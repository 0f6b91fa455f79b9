#include "nav_agent/bridge/robot_ports/laser_port.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "nav_agent/bridge/robot_ports/testing_ports.h"

namespace treeline::robot_ports {
namespace {

using ::testing::HasSubstr;

class LaserPortTest : public ::testing::Test {
 protected:
  // Range i + 1 m at beam i.
  messages::LaserScan Scan(int beams = 5) {
    testing_.real.Pass(0.025);
    messages::LaserScan scan;
    scan.header = {.stamp = testing_.Stamp(), .frame_id = "laser"};
    scan.angle_min = -1;
    scan.angle_increment = 2.0F / static_cast<float>(beams - 1);
    scan.range_max = 1000;
    for (int i = 0; i < beams; ++i) {
      scan.ranges.push_back(static_cast<float>(i + 1));
    }
    return scan;
  }

  TestingTime testing_;
  LaserPort port_{"scan", testing_.time, testing_.real};
};

TEST_F(LaserPortTest, ScansAreStampedInTheAgentsTime) {
  EXPECT_EQ(port_.Health().state, core::DeviceState::kStarting);
  EXPECT_THAT(std::string(port_.Health().cause.message()), HasSubstr("scan"));
  ASSERT_TRUE(port_.Add(Scan()).ok());
  EXPECT_EQ(port_.frame_id(), "laser");
  EXPECT_EQ(port_.Info().beams, 5);
  const std::vector<core::LaserScan> scans = port_.TakeScans();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_EQ(scans[0].stamp, testing_.real.Now());
  EXPECT_EQ(scans[0].ranges_m, std::vector<float>({1, 2, 3, 4, 5}));
  EXPECT_TRUE(port_.TakeScans().empty());
}

TEST_F(LaserPortTest, BeamsThatRunClockwiseAreTurnedRound) {
  messages::LaserScan scan = Scan();
  scan.angle_min = 1;
  scan.angle_increment = -0.5F;
  scan.time_increment = 0.001F;
  ASSERT_TRUE(port_.Add(scan).ok());
  EXPECT_NEAR(port_.Info().angle_min_rad, -1, 1e-6);
  EXPECT_NEAR(port_.Info().angle_increment_rad, 0.5, 1e-6);
  EXPECT_EQ(port_.Info().beam_interval_s, 0);
  const core::LaserScan turned = port_.TakeScans().at(0);
  EXPECT_EQ(turned.ranges_m, std::vector<float>({5, 4, 3, 2, 1}));
  EXPECT_NEAR(base::SecondsBetween(testing_.real.Now(), turned.stamp), 0.002,
              1e-6);
}

TEST_F(LaserPortTest, UpsideDownLeftIsRight) {
  ASSERT_TRUE(port_.Add(Scan()).ok());
  port_.SetUpsideDown();
  EXPECT_TRUE(port_.TakeScans().empty()) << "what was the wrong way round";
  messages::LaserScan scan = Scan();
  scan.angle_min = -0.2F;
  ASSERT_TRUE(port_.Add(scan).ok());
  EXPECT_EQ(port_.TakeScans().at(0).ranges_m,
            std::vector<float>({5, 4, 3, 2, 1}));
  // From 0.2 rad clockwise to -1.8: the last beam is the first.
  EXPECT_NEAR(port_.Info().angle_min_rad, -1.8, 1e-6);
}

TEST_F(LaserPortTest, ScansOfMoreOrFewerBeamsAreMadeLikeTheFirst) {
  ASSERT_TRUE(port_.Add(Scan(5)).ok());
  ASSERT_TRUE(port_.Add(Scan(9)).ok());
  ASSERT_TRUE(port_.Add(Scan(4)).ok());
  messages::LaserScan half = Scan(5);
  half.angle_increment = 0.25F;
  ASSERT_TRUE(port_.Add(half).ok());
  const std::vector<core::LaserScan> scans = port_.TakeScans();
  ASSERT_EQ(scans.size(), 4U);
  EXPECT_EQ(scans[1].ranges_m, std::vector<float>({1, 3, 5, 7, 9}));
  // At -1, -0.33, 0.33 and 1.
  EXPECT_EQ(scans[2].ranges_m[0], 1);
  EXPECT_EQ(scans[2].ranges_m[1], 2);
  EXPECT_EQ(scans[2].ranges_m[3], 3);
  EXPECT_EQ(scans[2].ranges_m[4], 4);
  // Only from -1 to 0: nothing was measured beyond.
  EXPECT_EQ(scans[3].ranges_m[2], 5);
  EXPECT_TRUE(std::isnan(scans[3].ranges_m[4]));
}

TEST_F(LaserPortTest, WhatIsNoScanIsCountedAndDropped) {
  ASSERT_TRUE(port_.Add(Scan()).ok());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  messages::LaserScan empty = Scan();
  empty.ranges.clear();
  messages::LaserScan endless = Scan();
  endless.angle_increment = 100;
  messages::LaserScan crooked = Scan();
  crooked.angle_min = nan;
  messages::LaserScan far = Scan();
  far.angle_min = 1e9F;
  for (const auto& scan : {empty, endless, crooked, far}) {
    EXPECT_EQ(port_.Add(scan).code(), absl::StatusCode::kInvalidArgument);
  }
  EXPECT_EQ(port_.Health().corrupt, 4);
  EXPECT_EQ(port_.Health().received, 1);
  EXPECT_EQ(port_.TakeScans().size(), 1U);
  // Ranges that are none are a scan's all the same.
  messages::LaserScan blind = Scan();
  blind.ranges.assign(5, nan);
  EXPECT_TRUE(port_.Add(blind).ok());
}

TEST_F(LaserPortTest, SilenceIsTold) {
  ASSERT_TRUE(port_.Add(Scan()).ok());
  EXPECT_EQ(port_.Health().state, core::DeviceState::kRunning);
  testing_.real.Pass(1.1);
  EXPECT_EQ(port_.Health().state, core::DeviceState::kLost);
  EXPECT_EQ(port_.Health().losses, 1);
  ASSERT_TRUE(port_.Add(Scan()).ok());
  EXPECT_EQ(port_.Health().state, core::DeviceState::kRunning);
  EXPECT_EQ(port_.Health().losses, 1);
}

TEST_F(LaserPortTest, WhoDoesNotTakeThemLosesTheOldest) {
  for (int i = 0; i < core::kMaxWaiting + 3; ++i) {
    ASSERT_TRUE(port_.Add(Scan()).ok());
  }
  EXPECT_EQ(port_.Health().dropped, 3);
  EXPECT_EQ(port_.TakeScans().size(), size_t{core::kMaxWaiting});
}

}  // namespace
}  // namespace treeline::robot_ports
