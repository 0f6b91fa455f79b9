// Scenario files as arbitrary bytes: no crash, and what is accepted is in
// order of time, with faults that exist and options that are valid.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <variant>

#include "absl/strings/string_view.h"
#include "simulation/simulator/scenario.h"
#include "simulation/simulator/scenario_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto scenario = treeline::simulator::ParseScenario(
      absl::string_view(reinterpret_cast<const char*>(data), size), "fuzz");
  if (!scenario.ok()) return 0;
  if (!scenario->options.robot.Validate().ok() ||
      !scenario->options.errors.Validate().ok() ||
      !scenario->options.sensors.Validate().ok()) {
    std::abort();
  }
  treeline::simulator::SimTime last{0};
  for (const treeline::simulator::ScenarioAction& action : scenario->actions) {
    if (action.at < last) std::abort();
    last = action.at;
    const auto* fault =
        std::get_if<treeline::simulator::FaultAction>(&action.what);
    if (fault != nullptr && !fault->fault.Validate().ok()) std::abort();
  }
  return 0;
}
