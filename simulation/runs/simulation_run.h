// Runs a scenario from beginning to end, and says what happened.
#ifndef SIMULATION_RUNS_SIMULATION_RUN_H_
#define SIMULATION_RUNS_SIMULATION_RUN_H_

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "simulation/simulator/scenario.h"
#include "simulation/simulator/simulator.h"

namespace treeline::runs {

struct SimulationRunOptions {
  simulator::Scenario scenario;
  // Drives along the world's tour from the beginning; without a duration, to
  // its end.
  std::optional<simulator::TourAction> tour;
  // An agent log is written there; empty: none. See
  // docs/reference/agent-log.md.
  std::string record_path;
  int jpeg_quality = 92;
};

struct SimulationResult {
  std::string world;
  uint64_t seed = 0;
  double simulated_s = 0;
  // Of this process, from the first step to the last: all threads.
  double processor_s = 0;
  simulator::TrueState final_state;
  bool tour_done = false;
  std::vector<simulator::SimEvent> events;
  // True positions, 40 in a second; teleports begin a new line.
  std::vector<std::vector<geometry::Vec3>> track;
  int64_t scans = 0;
  int64_t readings = 0;
  int64_t frames = 0;

  // Simulated seconds for one of the processor.
  double Factor() const {
    return processor_s > 0 ? simulated_s / processor_s : 0;
  }
  int Count(simulator::SimEventKind kind) const;
  int CollisionsOfRobot() const;
};

// `progress` is called with the simulated seconds so far. CANCELLED if `stop`
// is requested; what was recorded stays.
absl::StatusOr<SimulationResult> RunSimulation(
    simulator::Simulator& simulator, const SimulationRunOptions& options,
    const std::function<void(double simulated_s)>& progress,
    const std::stop_token& stop);

// What was run as text for people, and as JSON.
std::string SimulationSummary(const SimulationResult& result);
std::string SimulationJson(const SimulationResult& result);

}  // namespace treeline::runs

#endif  // SIMULATION_RUNS_SIMULATION_RUN_H_
