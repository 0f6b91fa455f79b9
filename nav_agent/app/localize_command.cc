// treeline-agent localize: AMCL over a recording.
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/match.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "nav_agent/app/commands.h"
#include "nav_agent/app/localization_run.h"
#include "nav_agent/core/map_file.h"
#include "nav_agent/recording/wean_map.h"

namespace treeline {
namespace {

constexpr const char* kFooter = R"(
Maps: map_server's YAML and PGM, or a map of Wean Hall (.dat, .dat.gz).
Logs: JSON as of the Intel Research Lab, CARMEN, or Wean Hall's; each may be
compressed.

Examples:
  treeline-agent localize --map wean.dat.gz --log robotdata1.log.gz --global \
      --json out.json --picture out.png
  treeline-agent localize --map level-0.yaml --log drive.log --initial 1,2,0.5)";

struct LocalizeFlags {
  std::string map;
  std::string log;
  std::vector<double> initial;
  bool global = false;
  uint64_t seed = 0;
  std::string json;
  std::string picture;
  bool quiet = false;
};

absl::StatusOr<OccupancyGrid> MapOf(const std::string& path) {
  return absl::EndsWith(path, ".yaml") || absl::EndsWith(path, ".yml")
             ? ReadMap(path)
             : ReadWeanMap(path);
}

void PrintSummary(const LocalizationResult& result) {
  std::string converged = "never sure of one place";
  if (result.converged_after_m.has_value()) {
    converged = absl::StrFormat("sure of its place after %.1f m",
                                *result.converged_after_m);
  }
  std::printf(
      "%zu scans; %s\n%.1f %% of the beams end within %.1f m of the map's "
      "obstacles\nan update takes %.2f ms (median), %.2f ms (p99) of processor "
      "time\n",
      result.scans.size(), converged.c_str(), 100 * result.agreement,
      kAgreement_m, result.median_update_ms, result.p99_update_ms);
}

absl::Status Localize(const LocalizeFlags& flags, const std::stop_token& stop) {
  if (flags.global == !flags.initial.empty()) {
    return absl::InvalidArgumentError(
        "where does it begin? Give either --initial X,Y,YAW or --global");
  }
  for (const std::string* path : {&flags.json, &flags.picture}) {
    if (!path->empty()) TL_RETURN_IF_ERROR(CheckWritable(*path));
  }
  TL_ASSIGN_OR_RETURN(const OccupancyGrid map, MapOf(flags.map));
  TL_ASSIGN_OR_RETURN(const LaserLog log, ReadLaserLog(flags.log));
  LocalizationRunOptions options;
  options.seed = flags.seed;
  if (!flags.initial.empty()) {
    options.initial_map_from_base =
        Rigid2{.translation = {flags.initial[0], flags.initial[1]},
               .yaw_rad = flags.initial[2]};
  }
  absl::StatusOr<LocalizationResult> result;
  {
    Progress progress("localizing", static_cast<int64_t>(log.scans.size()),
                      flags.quiet);
    result = LocalizeLog(
        map, log, options, [&progress] { progress.Add(1); }, stop);
  }
  TL_RETURN_IF_ERROR(result.status());
  PrintSummary(*result);
  if (!flags.json.empty()) {
    TL_RETURN_IF_ERROR(
        WriteFileAtomically(flags.json, LocalizationJson(*result)));
  }
  if (flags.picture.empty()) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const std::string png,
                      EncodePng(DrawLocalization(map, log, *result)));
  return WriteFileAtomically(flags.picture, png);
}

}  // namespace

Command AddLocalizeCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("localize", "Follow a recorded drive on a map (AMCL)");
  command->footer(kFooter);
  auto flags = std::make_shared<LocalizeFlags>();
  command->add_option("--map", flags->map, "The level's map")
      ->type_name("YAML")
      ->required();
  command->add_option("--log", flags->log, "Scans and odometry")
      ->type_name("FILE")
      ->required();
  command
      ->add_option("--initial", flags->initial,
                   "Where the drive begins, in m and rad; within half a metre")
      ->type_name("X,Y,YAW")
      ->delimiter(',')
      ->expected(3);
  command->add_flag("--global", flags->global, "It may begin anywhere");
  command->add_option("--seed", flags->seed, "Of the particles")
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--json", flags->json, "Write all estimates")
      ->type_name("FILE");
  command
      ->add_option("--picture", flags->picture,
                   "Write the map with the way that was taken")
      ->type_name("FILE.png");
  command->add_flag("--quiet", flags->quiet, "Show no progress");
  return {command, [flags](const std::stop_token& stop) {
            return Localize(*flags, stop);
          }};
}

}  // namespace treeline
