#include "nav_agent/app/suite/suite_flags.h"

#include "absl/strings/str_cat.h"

namespace treeline::suite_app {
namespace {

// Which runs: of what robot, where.
void AddRunFlags(CLI::App& command, const std::string& run, SuiteFlags& flags) {
  command.add_option("--worlds", flags.worlds, "To drive in")
      ->type_name("WORLD,...")
      ->delimiter(',')
      ->capture_default_str();
  command
      .add_option("--seeds", flags.seeds,
                  absl::StrCat("One ", run, " a world and seed"))
      ->type_name("FIRST-LAST,...")
      ->capture_default_str();
  command
      .add_option("--maps", flags.maps,
                  "perfect: as the world is (no model fits that); driven: made "
                  "by a simulated mapping drive")
      ->check(CLI::IsMember({"perfect", "driven"}))
      ->capture_default_str();
  command
      .add_option("--cache", flags.cache,
                  "Where driven maps and their models are kept")
      ->type_name("FOLDER")
      ->capture_default_str();
  command.add_flag("--no-rear-laser", flags.no_rear_laser,
                   "A robot that does not see what is behind it");
  command
      .add_option(
          "--threads", flags.threads,
          absl::StrCat("How many ", run,
                       "s at a time; 0: one a processor. Results do not "
                       "depend on it"))
      ->type_name("N")
      ->check(CLI::Range(0, 1024));
}

// What becomes of them.
void AddReportFlags(CLI::App& command, const std::string& run,
                    SuiteFlags& flags) {
  command
      .add_option(
          "--require", flags.require,
          absl::StrCat("Fail if a smaller share of the ", run, "s is good"))
      ->type_name("SHARE")
      ->check(CLI::Range(0.0, 1.0));
  command.add_option("--json", flags.json, "Write all figures")
      ->type_name("FILE");
  command.add_option("--folder", flags.folder, "Where pictures and logs go")
      ->type_name("FOLDER")
      ->capture_default_str();
  command
      .add_option("--pictures", flags.pictures,
                  absl::StrCat("Of which ", run, "s"))
      ->check(CLI::IsMember({"none", "failed", "all"}))
      ->capture_default_str();
  command.add_flag("--quiet", flags.quiet, "Show no progress");
}

}  // namespace

suites::SuiteMapOptions SuiteFlags::MapOptions(const std::string& world) const {
  return {.world = world,
          .is_driven = maps == "driven",
          .with_people = people,
          .cache = cache,
          .quiet = quiet};
}

void AddSuiteFlags(CLI::App& command, const std::string& run,
                   SuiteFlags& flags) {
  AddRunFlags(command, run, flags);
  AddReportFlags(command, run, flags);
}

}  // namespace treeline::suite_app
