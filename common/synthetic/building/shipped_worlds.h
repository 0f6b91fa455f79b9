// The world files of common/synthetic/worlds, which every program carries.
#ifndef COMMON_SYNTHETIC_BUILDING_SHIPPED_WORLDS_H_
#define COMMON_SYNTHETIC_BUILDING_SHIPPED_WORLDS_H_

#include <span>

#include "absl/strings/string_view.h"

namespace treeline {

struct ShippedWorld {
  absl::string_view name;  // of the file, without .yaml
  absl::string_view text;
};

// In the order in which they are shown to people.
std::span<const ShippedWorld> ShippedWorlds();

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_BUILDING_SHIPPED_WORLDS_H_
