// Options of command lines that say in which state a world is.
#ifndef SIMULATION_WORLDS_WORLD_FLAGS_H_
#define SIMULATION_WORLDS_WORLD_FLAGS_H_

#include <optional>
#include <string>

#include "simulation/worlds/world.h"

namespace CLI {
class App;
}

namespace treeline::worlds {

// Adds an option (--light, for instance) that takes a light's name. `lighting`
// must outlive the command.
void AddLightFlag(CLI::App& command, const std::string& name,
                  const std::string& help,
                  std::optional<building::Lighting>& lighting);

// Adds --rearranged SEED:SHARE. `rearranged` must outlive the command.
void AddRearrangedFlag(CLI::App& command, Rearrangement& rearranged);

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_WORLD_FLAGS_H_
