#include "nav_agent/app/traversability/traversability_command.h"

#include <cstdio>
#include <memory>
#include <numbers>

#include "CLI/CLI.hpp"
#include "common/base/status_macros.h"
#include "nav_agent/traversability/level_files.h"

namespace treeline::traversability_app {
namespace {

constexpr const char* kFooter = R"(
Writes for each level N, from the bottom up: level-N.yaml and level-N.pgm (a map
as map_server reads it), level-N-height.pgm, -slope.pgm and -clearance.pgm (16
bits; layers.yaml says of what), and level-N.png to look at.
docs/explanation/traversability.md describes the method and its limits.

Example:
  treeline-agent traversability --octomap house.bt --output house \
      --max-slope-deg 10)";

constexpr double kDegPerRad = 180 / std::numbers::pi;

struct TraversabilityFlags {
  traversability::TraversabilityCommand command;
  double max_slope_deg = command.options.max_slope_rad * kDegPerRad;
};

absl::Status Run(TraversabilityFlags& flags) {
  flags.command.options.max_slope_rad = flags.max_slope_deg / kDegPerRad;
  TL_ASSIGN_OR_RETURN(const traversability::TraversabilitySummary summary,
                      traversability::RunTraversability(flags.command));
  std::printf("Levels %d, joins %d, free cells %lld, occupied cells %lld\n",
              summary.levels, summary.joins,
              static_cast<long long>(summary.free_cells),
              static_cast<long long>(summary.occupied_cells));
  std::printf("Extracted in %.1f ms; written to %s\n", summary.extraction_ms,
              flags.command.output_folder.c_str());
  if (summary.free_cells == 0) {
    std::fprintf(
        stderr,
        "note: a robot may drive nowhere: the OctoMap has no ground of "
        "these limits. That of a bundle of a laser alone has none at "
        "all: its levels are in the bundle\n");
  }
  return absl::OkStatus();
}

}  // namespace

cli::Command AddTraversabilityCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "traversability", "Find where a robot may drive, from an OctoMap");
  command->footer(kFooter);
  auto flags = std::make_shared<TraversabilityFlags>();
  traversability::TraversabilityOptions& options = flags->command.options;
  command
      ->add_option("--octomap", flags->command.octomap_path,
                   "The OctoMap, .bt or .ot")
      ->type_name("FILE")
      ->required();
  command
      ->add_option("--output", flags->command.output_folder,
                   "The folder for the result; made if it is not there")
      ->type_name("DIR")
      ->required();
  const auto add = [command](const char* name, double& value,
                             const char* description, const char* unit) {
    command->add_option(name, value, description)
        ->type_name(unit)
        ->capture_default_str();
  };
  add("--max-slope-deg", flags->max_slope_deg,
      "Ground this steep is not driven on", "DEG");
  add("--max-step", options.max_step_m, "The highest step driven over", "M");
  add("--robot-height", options.robot_height_m, "Room that is needed", "M");
  add("--min-ground-width", options.min_ground_width_m,
      "Ground between steps that is narrower is a tread", "M");
  add("--min-platform-area", options.min_platform_area_m2,
      "Raised ground that is smaller is furniture", "M2");
  add("--occupied-threshold", flags->command.occupied_threshold,
      "Probability from which an .ot file's voxel is occupied", "P");
  return {command,
          [flags](const std::stop_token& /*stop*/) { return Run(*flags); }};
}

}  // namespace treeline::traversability_app
