#include "simulation/worlds/world_flags.h"

#include <vector>

#include "CLI/CLI.hpp"
#include "simulation/worlds/rearrange.h"

namespace treeline::worlds {

void AddLightFlag(CLI::App& command, const std::string& name,
                  const std::string& help,
                  std::optional<building::Lighting>& lighting) {
  std::vector<std::string> names;
  for (const absl::string_view known : building::LightingNames()) {
    names.emplace_back(known);
  }
  command
      .add_option_function<std::string>(
          name,
          [&lighting](const std::string& text) {
            lighting = *building::ParseLighting(text);
          },
          help)
      ->type_name("NAME")
      ->check(CLI::IsMember(names));
}

void AddRearrangedFlag(CLI::App& command, Rearrangement& rearranged) {
  command
      .add_option_function<std::string>(
          "--rearranged",
          [&rearranged](const std::string& text) {
            const absl::StatusOr<Rearrangement> parsed =
                ParseRearrangement(text);
            if (!parsed.ok()) {
              throw CLI::ValidationError(
                  "--rearranged", std::string(parsed.status().message()));
            }
            rearranged = *parsed;
          },
          "Of the furniture that can be moved, this share is missing or stands "
          "up to 1 m from its place")
      ->type_name("SEED:SHARE");
}

}  // namespace treeline::worlds
