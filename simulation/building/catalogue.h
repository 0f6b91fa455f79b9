// Names that a building's plan may use: materials, and pieces of furniture.
#ifndef SIMULATION_BUILDING_CATALOGUE_H_
#define SIMULATION_BUILDING_CATALOGUE_H_

#include <optional>
#include <span>
#include <string>

#include "absl/strings/string_view.h"

namespace treeline::building {

std::span<const absl::string_view> Materials();

// What a piece of furniture covers, seen from above: width_m along its front.
// Its middle is where the plan says that it stands.
struct FurnitureKind {
  absl::string_view name;
  double width_m = 0;
  double depth_m = 0;
  // Bounds of the width; both 0: it has one width only.
  double min_width_m = 0;
  double max_width_m = 0;
  // Its origin is the middle of its footprint, not its back left corner (see
  // Placement).
  bool is_centred = false;
  // Whether people push it about or carry it away.
  bool can_move = false;
};
std::span<const FurnitureKind> FurnitureKinds();
// Null if there is none of this name.
const FurnitureKind* FindFurniture(absl::string_view name);

// "; did you mean 'x'?", or "; there are a, b, c".
std::string Suggestion(absl::string_view unknown,
                       std::span<const absl::string_view> known);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_CATALOGUE_H_
