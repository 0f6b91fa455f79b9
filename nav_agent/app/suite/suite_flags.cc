#include "nav_agent/app/suite/suite_flags.h"

#include "absl/strings/str_cat.h"
#include "simulation/worlds/world_flags.h"

namespace treeline::suite_app {
namespace {

// Which runs: of what robot, where.
void AddRunFlags(CLI::App& command, const std::string& run,
                 suites::SuiteOptions& options) {
  AddWorldFlags(command, run, options.worlds, options.seeds);
  command
      .add_option("--maps", options.maps,
                  "perfect: as the world is (no model fits that); driven: made "
                  "by a simulated mapping drive")
      ->check(CLI::IsMember({"perfect", "driven"}))
      ->capture_default_str();
  command
      .add_option("--cache", options.cache,
                  "Where driven maps and their models are kept")
      ->type_name("FOLDER")
      ->capture_default_str();
  worlds::AddRearrangedFlag(command, options.rearranged);
  command.add_flag("--no-rear-laser", options.no_rear_laser,
                   "A robot that does not see what is behind it");
  command
      .add_option(
          "--threads", options.threads,
          absl::StrCat("How many ", run,
                       "s at a time; 0: one a processor. Results do not "
                       "depend on it"))
      ->type_name("N")
      ->check(CLI::Range(0, 1024));
}

// What becomes of them.
void AddReportFlags(CLI::App& command, const std::string& run,
                    suites::SuiteOptions& options) {
  command
      .add_option(
          "--require", options.require,
          absl::StrCat("Fail if a smaller share of the ", run, "s is good"))
      ->type_name("SHARE")
      ->check(CLI::Range(0.0, 1.0));
  command.add_option("--json", options.json, "Write all figures")
      ->type_name("FILE");
  command.add_option("--folder", options.folder, "Where pictures and logs go")
      ->type_name("FOLDER")
      ->capture_default_str();
  command
      .add_option("--pictures", options.pictures,
                  absl::StrCat("Of which ", run, "s"))
      ->check(CLI::IsMember({"none", "failed", "all"}))
      ->capture_default_str();
  command.add_flag("--quiet", options.quiet, "Show no progress");
}

}  // namespace

void AddWorldFlags(CLI::App& command, const std::string& run,
                   std::vector<std::string>& worlds, std::string& seeds) {
  command.add_option("--worlds", worlds, "To drive in")
      ->type_name("WORLD,...")
      ->delimiter(',')
      ->capture_default_str();
  command
      .add_option("--seeds", seeds,
                  absl::StrCat("One ", run, " a world and seed"))
      ->type_name("FIRST-LAST,...")
      ->capture_default_str();
}

void AddRobotFlag(CLI::App& command, suites::SuiteOptions& options) {
  command
      .add_option(
          "--robot", options.robot,
          "rmp100, jackal, turtlebot3, or a file (docs/reference/robots.md)")
      ->type_name("ROBOT")
      ->capture_default_str();
}

void AddSuiteFlags(CLI::App& command, const std::string& run,
                   suites::SuiteOptions& options) {
  AddRunFlags(command, run, options);
  AddReportFlags(command, run, options);
}

}  // namespace treeline::suite_app
