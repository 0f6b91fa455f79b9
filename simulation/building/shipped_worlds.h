// The world files of simulation/worlds/shipped, which every program carries.
#ifndef SIMULATION_BUILDING_SHIPPED_WORLDS_H_
#define SIMULATION_BUILDING_SHIPPED_WORLDS_H_

#include <span>

#include "absl/strings/string_view.h"

namespace treeline::building {

struct ShippedWorld {
  absl::string_view name;  // of the file, without .yaml
  absl::string_view text;
};

// In the order in which they are shown to people.
std::span<const ShippedWorld> ShippedWorlds();

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_SHIPPED_WORLDS_H_
