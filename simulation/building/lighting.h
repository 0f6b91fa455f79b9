// The lights that a world can be seen in, by name.
#ifndef SIMULATION_BUILDING_LIGHTING_H_
#define SIMULATION_BUILDING_LIGHTING_H_

#include <cstdint>
#include <span>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/yaml/yaml_node.h"

namespace treeline::building {

enum class Lighting : uint8_t {
  kDay,        // an overcast sky in the windows, and all lamps
  kSunny,      // the sun through the windows, and all lamps
  kLampsOff,   // an overcast sky alone
  kEvening,    // dusk outside, all lamps, warm
  kHalfLamps,  // dark outside, about every second lamp
  kNight       // street lamps outside, none inside
};

// By value of Lighting: "day", "sunny", ...
std::span<const absl::string_view> LightingNames();
absl::string_view LightingName(Lighting lighting);
// INVALID_ARGUMENT, with the names that there are, for others.
absl::StatusOr<Lighting> ParseLighting(absl::string_view name);
// The same of a text in a file; errors name file and line.
absl::StatusOr<Lighting> ReadLighting(const yaml::YamlNode& node);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_LIGHTING_H_
