// Scenarios from files; docs/reference/simulator.md describes them.
#ifndef SIMULATION_SIMULATOR_SCENARIO_READER_H_
#define SIMULATION_SIMULATOR_SCENARIO_READER_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "simulation/simulator/scenario.h"

namespace treeline::simulator {

// The scenario in a YAML text. INVALID_ARGUMENT begins with "NAME:LINE: ".
absl::StatusOr<Scenario> ParseScenario(absl::string_view text,
                                       absl::string_view name);
absl::StatusOr<Scenario> ReadScenario(const std::string& path);

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_SCENARIO_READER_H_
