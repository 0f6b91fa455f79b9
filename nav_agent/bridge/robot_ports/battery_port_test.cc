#include "nav_agent/bridge/robot_ports/battery_port.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "nav_agent/behavior/testing_devices.h"

namespace treeline::robot_ports {
namespace {

using ::testing::HasSubstr;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

TEST(BatteryPortTest, WhatIsNotANumberIsNotTold) {
  behavior::ManualClock clock;
  BatteryPort port(clock);
  EXPECT_EQ(port.battery(), std::nullopt);
  ASSERT_TRUE(
      port.Add({.voltage = 24.5f,
                .percentage = 0.75f,
                .power_supply_status = messages::BatteryState::kCharging})
          .ok());
  EXPECT_EQ(port.battery(), (core::Battery{.voltage_v = 24.5,
                                           .charge = 0.75,
                                           .charging = core::Charging::kYes}));
  ASSERT_TRUE(
      port.Add({.voltage = kNaN,
                .percentage = kNaN,
                .power_supply_status = messages::BatteryState::kDischarging})
          .ok());
  EXPECT_EQ(port.battery(), (core::Battery{.charging = core::Charging::kNo}));
  ASSERT_TRUE(
      port.Add({.power_supply_status = messages::BatteryState::kFull}).ok());
  EXPECT_EQ(port.battery()->charging, core::Charging::kUnknown);
}

TEST(BatteryPortTest, WhatCannotBeIsRefusedAndTheLastStays) {
  behavior::ManualClock clock;
  BatteryPort port(clock);
  ASSERT_TRUE(port.Add({.voltage = 12, .percentage = 0.5f}).ok());
  EXPECT_THAT(std::string(port.Add({.percentage = 75}).message()),
              HasSubstr("from 0 to 1"));
  EXPECT_FALSE(port.Add({.voltage = -1, .percentage = 0.5f}).ok());
  EXPECT_EQ(port.battery()->voltage_v, 12);
}

TEST(BatteryPortTest, ASilentBatteryIsNotKnown) {
  behavior::ManualClock clock;
  BatteryPort port(clock);
  ASSERT_TRUE(port.Add({.voltage = 12, .percentage = 0.5f}).ok());
  clock.Advance_s(59);
  EXPECT_TRUE(port.battery().has_value());
  clock.Advance_s(2);
  EXPECT_EQ(port.battery(), std::nullopt);
}

}  // namespace
}  // namespace treeline::robot_ports
