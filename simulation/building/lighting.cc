#include "simulation/building/lighting.h"

#include <array>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "simulation/building/catalogue.h"

namespace treeline::building {
namespace {

constexpr std::array<absl::string_view, 6> kNames = {
    "day", "sunny", "lamps-off", "evening", "half-lamps", "night"};

}  // namespace

std::span<const absl::string_view> LightingNames() { return kNames; }

absl::string_view LightingName(Lighting lighting) {
  return kNames[static_cast<size_t>(lighting)];
}

absl::StatusOr<Lighting> ParseLighting(absl::string_view name) {
  for (size_t i = 0; i < kNames.size(); ++i) {
    if (kNames[i] == name) return static_cast<Lighting>(i);
  }
  return absl::InvalidArgumentError(
      absl::StrCat("there is no light '", name, "'", Suggestion(name, kNames)));
}

absl::StatusOr<Lighting> ReadLighting(const yaml::YamlNode& node) {
  TL_ASSIGN_OR_RETURN(const std::string name, node.AsText());
  absl::StatusOr<Lighting> lighting = ParseLighting(name.substr(0, 40));
  if (!lighting.ok()) return node.Error(lighting.status().message());
  return lighting;
}

}  // namespace treeline::building
