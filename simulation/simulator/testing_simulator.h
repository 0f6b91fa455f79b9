// What the simulator's tests share.
#ifndef SIMULATION_SIMULATOR_TESTING_SIMULATOR_H_
#define SIMULATION_SIMULATOR_TESTING_SIMULATOR_H_

#include <memory>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "simulation/simulator/simulator.h"
#include "simulation/simulator/testing_places.h"

namespace treeline::simulator {

// A robot without errors and without a laser, somewhere.
inline SimulatorOptions StartAt(double x_m, double y_m, double yaw_rad = 0,
                                double height_m = 0) {
  SimulatorOptions options;
  options.errors = WheelOdometryErrors::None();
  options.sensors.has_laser = false;
  options.start = {
      .position = {x_m, y_m}, .yaw_rad = yaw_rad, .height_m = height_m};
  return options;
}

inline std::unique_ptr<Simulator> MakeSimulator(
    worlds::World world, const SimulatorOptions& options) {
  auto simulator = Simulator::Create(std::move(world), options);
  EXPECT_TRUE(simulator.ok()) << simulator.status();
  return simulator.ok() ? *std::move(simulator) : nullptr;
}

// Drives for a while, with a command every 100 ms.
inline void Drive(Simulator& simulator, core::VelocityCommand command,
                  double duration_s) {
  for (int i = 0; i < static_cast<int>(duration_s * 10 + 0.5); ++i) {
    simulator.base().SetVelocity(command).IgnoreError();
    simulator.Step(std::chrono::milliseconds(100));
  }
}

inline geometry::Vec3 PositionOf(const Simulator& simulator) {
  return simulator.state().world_from_base.translation;
}

inline std::vector<SimEvent> EventsOf(Simulator& simulator, SimEventKind kind) {
  std::vector<SimEvent> chosen;
  for (SimEvent& event : simulator.TakeEvents()) {
    if (event.kind == kind) chosen.push_back(std::move(event));
  }
  return chosen;
}

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_TESTING_SIMULATOR_H_
