#include "simulation/building/catalogue.h"

#include <array>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/nearest_name.h"

namespace treeline::building {
namespace {

constexpr std::array<absl::string_view, 12> kMaterials = {
    "white",  "plain", "plaster", "wallpaper", "brick",  "concrete",
    "planks", "wood",  "tiles",   "carpet",    "rubber", "noise"};

constexpr std::array<FurnitureKind, 21> kFurniture = {{
    {"bookcase", 0.9, 0.3, 0.4, 2.0},
    {"desk", 1.5, 0.75},
    {"sideboard", 1.5, 0.45, 0.6, 2.5},
    {"wardrobe", 1.0, 0.6},
    {"sofa", 1.9, 0.9, 0, 0, false, true},
    {"floor_lamp", 0.4, 0.4, 0, 0, false, true},
    {"plant", 0.4, 0.4, 0, 0, false, true},
    {"boxes", 0.7, 0.5, 0, 0, false, true},
    {"chair", 0.44, 0.44, 0, 0, true, true},
    {"coffee_table", 1.0, 0.6, 0, 0, true, true},
    {"cafe_table", 0.7, 0.7, 0, 0, true, true},
    {"table", 1.6, 0.8, 0.8, 3.0, true, true},
    {"counter", 2.4, 0.7, 1.0, 6.0, true},
    {"bench", 1.4, 0.4, 0.6, 3.0, true, true},
    {"stool", 0.36, 0.36, 0, 0, true, true},
    {"machine", 0.95, 0.8, 0, 0, true},
    {"office_chair", 0.6, 0.6, 0, 0, true, true},
    {"bin", 0.32, 0.32, 0, 0, true, true},
    {"rack", 1.2, 0.45, 0.6, 2.4, true},
    {"crate", 0.6, 0.6, 0.3, 1.2, true, true},
    {"rug", 2.0, 1.4, 0.8, 4.0, true},
}};

}  // namespace

std::span<const absl::string_view> Materials() { return kMaterials; }
std::span<const FurnitureKind> FurnitureKinds() { return kFurniture; }

const FurnitureKind* FindFurniture(absl::string_view name) {
  for (const FurnitureKind& kind : kFurniture) {
    if (kind.name == name) return &kind;
  }
  return nullptr;
}

std::string Suggestion(absl::string_view unknown,
                       std::span<const absl::string_view> known) {
  const std::string nearest = base::NearestName(unknown, known);
  if (!nearest.empty()) return absl::StrCat("; did you mean '", nearest, "'?");
  return absl::StrCat("; there are ",
                      absl::StrJoin(known.begin(), known.end(), ", "));
}

}  // namespace treeline::building
