#include "simulation/simulator/simulated_battery.h"

#include <gtest/gtest.h>

namespace treeline::simulator {
namespace {

TEST(SimulatedBatteryTest, DrainsFasterWhileDrivingAndNeverBelowEmpty) {
  SimulatedBattery battery(
      {.full_v = 80, .empty_v = 60, .standing_s = 1000, .driving_s = 100});
  EXPECT_EQ(battery.charge(), 1);
  EXPECT_EQ(battery.voltage_v(), 80);
  battery.Drain(100, false);
  EXPECT_DOUBLE_EQ(battery.charge(), 0.9);
  battery.Drain(40, true);
  EXPECT_DOUBLE_EQ(battery.charge(), 0.5);
  EXPECT_DOUBLE_EQ(battery.voltage_v(), 70);
  battery.Drain(1000, true);
  EXPECT_EQ(battery.charge(), 0);
  EXPECT_EQ(battery.voltage_v(), 60);
}

}  // namespace
}  // namespace treeline::simulator
