// One drive of the local controller through a simulated world. The true pose
// stands in for an estimate, optionally with an error that wanders.
#ifndef TESTS_CONTROL_CONTROL_RUN_H_
#define TESTS_CONTROL_CONTROL_RUN_H_

#include <functional>
#include <string>
#include <vector>

#include "nav_agent/control/local_controller.h"
#include "simulation/simulator/simulator.h"
#include "tests/control/control_world.h"

namespace treeline {

struct ControlRunOptions {
  double max_s = 180;
  // Standard deviations of the estimate's error (m, rad).
  double error_m = 0;
  double error_rad = 0;
  uint64_t seed = 1;
  bool traces = false;
  // Called before each step.
  std::function<void(simulator::Simulator& simulator)> before_step;
};

struct ControlRunResult {
  bool arrived = false;
  double seconds = 0;
  double driven_m = 0;
  double path_m = 0;
  // Of the true pose at the end.
  double error_m = 0;
  double error_rad = 0;
  int collisions_caused = 0;
  int collisions_suffered = 0;
  int falls = 0;
  int times_blocked = 0;
  double waited_s = 0;
  double guarded_s = 0;
  // How often the forward speed went from growing to falling or back by more
  // than 0.1 m/s, and the yaw rate by more than 0.3 rad/s.
  int speed_swings = 0;
  int turn_swings = 0;
  double longest_step_ms = 0;
  double mean_step_ms = 0;
  std::string why;
};

ControlRunResult RunControl(const ControlWorld& world,
                            simulator::Simulator& simulator,
                            control::LocalController& controller,
                            const std::vector<core::LevelPose>& path,
                            const ControlRunOptions& options);

// The estimate at a time: the truth.
control::ControlPose TruePose(const ControlWorld& world,
                              const simulator::Simulator& simulator,
                              simulator::SimTime time,
                              const core::BaseReading& reading);

}  // namespace treeline

#endif  // TESTS_CONTROL_CONTROL_RUN_H_
