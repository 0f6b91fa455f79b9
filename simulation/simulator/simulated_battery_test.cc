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

TEST(SimulatedBatteryTest, ChargesWhereTheContactsMeet) {
  SimulatedBattery battery(
      {.driving_s = 100, .charging_s = 50, .charge = 0.25});
  battery.Charge(25);
  EXPECT_DOUBLE_EQ(battery.charge(), 0.75);
  battery.Charge(100);
  EXPECT_EQ(battery.charge(), 1);
  const Chargers chargers({{.map_from_docked = {{2, 3}, 1}, .height_m = 4}});
  const auto touch = [&](double x_m, double y_m, double yaw_rad, double z_m) {
    return chargers.Touch(
        {.rotation = geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad}),
         .translation = {x_m, y_m, z_m}});
  };
  EXPECT_TRUE(touch(2, 3, 1, 4));
  EXPECT_TRUE(touch(2.01, 2.99, 1.05, 4.1));
  EXPECT_FALSE(touch(2.05, 3, 1, 4));
  EXPECT_FALSE(touch(2, 2.95, 1, 4));
  EXPECT_FALSE(touch(2, 3, 1.2, 4));
  EXPECT_FALSE(touch(2, 3, 1, 0));
  EXPECT_FALSE(Chargers().Touch({}));
}

}  // namespace
}  // namespace treeline::simulator
