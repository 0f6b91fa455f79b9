#include "nav_agent/app/doctor/doctor.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"

namespace treeline::doctor_app {
namespace {

// A device that gives this share of what it promises has a bad cable.
constexpr double kEnoughRate = 0.8;
// Of a scan's beams: real places have walls.
constexpr double kFewRanges = 0.3;
constexpr double kManyInvalid = 0.2;
// Of lead-acid and lithium packs of 72 V nominal, a Segway's.
constexpr double kLowBattery_v = 68;
constexpr double kBaseHz = 50;
constexpr double kFewDepth = 0.2;
constexpr double kDark = 25;
constexpr double kSlowServer_s = 0.5;
constexpr uint64_t kMiB = uint64_t{1} << 20;
constexpr uint64_t kLittleDisk = 5 * 1024 * kMiB;
constexpr uint64_t kNoDisk = 200 * kMiB;
// 2025: before this software.
constexpr double kEarliest_s = 1735689600;

Finding Silent(const std::string& what, const core::DeviceHealth& health,
               const std::string& mend) {
  return {.what = what,
          .verdict = Verdict::kFail,
          .found = health.cause.ok() ? "nothing was heard"
                                     : std::string(health.cause.message()),
          .mend = mend};
}

Finding Rate(const std::string& what, double hz, double wanted_hz,
             const core::DeviceHealth& health) {
  Finding finding{
      .what = what + ": rate",
      .verdict = Verdict::kOk,
      .found = absl::StrFormat("%.1f Hz of %.1f; %d corrupt, %d dropped", hz,
                               wanted_hz, health.corrupt, health.dropped),
      .mend = ""};
  if (hz < kEnoughRate * wanted_hz || health.corrupt > 0) {
    finding.verdict = Verdict::kWarn;
    finding.mend =
        "check cable and connectors, and that no other program loads the "
        "machine or uses the device";
  }
  return finding;
}

int64_t FreeCells(const traversability::TraversableLevel& level) {
  return std::count(level.grid.cells.begin(), level.grid.cells.end(),
                    core::Occupancy::kFree);
}

const char* const kRemap =
    "map the place again (treeline-agent map), and look at map.png";

}  // namespace

const char* VerdictName(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return "ok";
    case Verdict::kWarn:
      return "warn";
    case Verdict::kFail:
      return "fail";
  }
  return "fail";
}

std::vector<Finding> JudgeLaser(const HeardLaser& heard) {
  if (heard.scans.empty()) {
    return {Silent(
        heard.name, heard.health,
        "check its power and its address; docs/reference/laser-driver.md has "
        "the causes")};
  }
  const double hz = static_cast<double>(heard.scans.size()) / heard.seconds;
  std::vector<Finding> findings = {
      Rate(heard.name, hz, 1 / heard.info.scan_interval_s, heard.health)};
  int64_t ranges = 0;
  int64_t invalid = 0;
  int64_t all = 0;
  for (const core::LaserScan& scan : heard.scans) {
    for (const float range : scan.ranges_m) {
      ++all;
      if (std::isnan(range)) ++invalid;
      if (std::isfinite(range) && range >= heard.info.range_min_m &&
          range <= heard.info.range_max_m) {
        ++ranges;
      }
    }
  }
  const double share =
      all == 0 ? 0 : static_cast<double>(ranges) / static_cast<double>(all);
  const double bad =
      all == 0 ? 1 : static_cast<double>(invalid) / static_cast<double>(all);
  Finding finding{.what = absl::StrCat(heard.name, ": ranges"),
                  .verdict = Verdict::kOk,
                  .found = absl::StrFormat(
                      "%.0f %% of %d beams see something, %.0f %% invalid",
                      100 * share, heard.info.beams, 100 * bad),
                  .mend = ""};
  if (bad > kManyInvalid) {
    finding.verdict = Verdict::kFail;
    finding.mend = "clean its window; if that does not help, it is broken";
  } else if (share < kFewRanges) {
    finding.verdict = Verdict::kWarn;
    finding.mend =
        "hardly anything is in its range: is it covered, or does it look at "
        "the sky?";
  }
  findings.push_back(std::move(finding));
  return findings;
}

std::vector<Finding> JudgeBase(const HeardBase& heard) {
  if (heard.readings.empty()) {
    return {Silent(
        "base", heard.health,
        "switch it on and check its address; docs/reference/base-driver.md "
        "has the causes")};
  }
  const double hz = static_cast<double>(heard.readings.size()) / heard.seconds;
  std::vector<Finding> findings = {Rate("base", hz, kBaseHz, heard.health)};
  const core::BaseReading& last = heard.readings.back();
  Finding battery{.what = "base: battery",
                  .verdict = Verdict::kOk,
                  .found = absl::StrFormat("%.1f V", last.battery_v),
                  .mend = ""};
  if (last.battery_v <= 0) {
    battery.found = "it does not tell";
  } else if (last.battery_v < kLowBattery_v) {
    battery.verdict = Verdict::kWarn;
    battery.mend = "charge it";
  }
  findings.push_back(std::move(battery));
  Finding motors{.what = "base: motors",
                 .verdict = Verdict::kOk,
                 .found = "enabled",
                 .mend = ""};
  if (!last.motors_enabled) {
    motors.verdict = Verdict::kFail;
    motors.found = "disabled";
    motors.mend = "release the emergency stop, and switch the base on again";
  }
  findings.push_back(std::move(motors));
  return findings;
}

std::vector<Finding> JudgeCamera(const HeardCamera& heard) {
  if (heard.frames == 0) {
    return {
        Silent("camera", heard.health,
               "plug it in at a USB port of its own; docs/reference/cameras.md "
               "has the causes")};
  }
  Finding finding{.what = "camera",
                  .verdict = Verdict::kOk,
                  .found = absl::StrFormat(
                      "%.1f frames a second, depth in %.0f %% of the picture, "
                      "brightness %.0f of 255",
                      static_cast<double>(heard.frames) / heard.seconds,
                      100 * heard.depth_share, heard.brightness),
                  .mend = ""};
  if (heard.depth_share < kFewDepth) {
    finding.verdict = Verdict::kWarn;
    finding.mend =
        "hardly any depth: is the lens covered, the sun on it, or a wall "
        "nearer than 0.4 m?";
  } else if (heard.brightness < kDark) {
    finding.verdict = Verdict::kWarn;
    finding.mend = "it is dark: switch on the light; a lost robot sees nothing";
  }
  return {finding};
}

Finding JudgeCalibration(
    const std::string& drive,
    const absl::StatusOr<calibration::Calibration>& calibration) {
  Finding finding{.what = "calibration",
                  .verdict = Verdict::kWarn,
                  .found = "",
                  .mend = ""};
  if (!calibration.ok()) {
    finding.found = std::string(calibration.status().message());
    finding.mend =
        "record another drive; docs/how-to/calibrate-a-robot.md says how";
    return finding;
  }
  std::vector<std::string> off;
  for (const calibration::Misfit& misfit :
       calibration::FindMisfits(*calibration)) {
    off.push_back(absl::StrFormat(
        "%s is %.4f %s, not %.4f (+- %.4f)",
        calibration::NameOf(misfit.quantity), misfit.found,
        calibration::UnitOf(misfit.quantity), misfit.assumed, misfit.sigma));
  }
  if (std::string noise = calibration::NoiseMisfit(*calibration);
      !noise.empty()) {
    off.push_back(std::move(noise));
  }
  if (off.empty()) {
    finding.verdict = Verdict::kOk;
    finding.found = absl::StrCat("fits ", drive);
    return finding;
  }
  finding.found = absl::StrCat("in ", drive, " ", absl::StrJoin(off, "; "));
  finding.mend = absl::StrCat("calibrate anew: treeline-agent calibrate ",
                              drive, " --write FILE");
  return finding;
}

std::vector<Finding> JudgeMap(
    const std::string& path,
    const absl::StatusOr<behavior::NavigatorMap>& map) {
  if (!map.ok()) {
    return {{.what = "map",
             .verdict = Verdict::kFail,
             .found = std::string(map.status().message()),
             .mend = absl::StrCat(
                 "give --map the folder that treeline-agent map wrote, or the "
                 "YAML of a map of map_server")}};
  }
  int64_t free_cells = 0;
  std::vector<std::string> levels;
  for (const traversability::TraversableLevel& level : map->levels.levels) {
    const int64_t cells = FreeCells(level);
    free_cells += cells;
    levels.push_back(absl::StrFormat("%.0f m2", static_cast<double>(cells) *
                                                    level.grid.resolution_m *
                                                    level.grid.resolution_m));
  }
  std::vector<Finding> findings = {
      {.what = "map",
       .verdict = Verdict::kOk,
       .found =
           absl::StrCat(path, ": ", map->voxels.CountOccupied(), " voxels"),
       .mend = ""}};
  Finding free{.what = "map: free ground",
               .verdict = Verdict::kOk,
               .found = absl::StrCat(levels.size(),
                                     " levels: ", absl::StrJoin(levels, ", ")),
               .mend = ""};
  if (free_cells == 0) {
    free.verdict = Verdict::kFail;
    free.found += "; the robot can stand nowhere";
    free.mend = kRemap;
  }
  findings.push_back(std::move(free));
  if (levels.size() > 1) {
    const size_t joins = map->levels.joins.size();
    Finding joined{
        .what = "map: joins",
        .verdict = Verdict::kOk,
        .found = absl::StrCat(joins, " between ", levels.size(), " levels"),
        .mend = ""};
    if (joins + 1 < levels.size()) {
      joined.verdict = Verdict::kWarn;
      joined.mend =
          "no ramp leads to some level: goals there are refused. If there is "
          "one, drive over it while mapping";
    }
    findings.push_back(std::move(joined));
  }
  return findings;
}

std::vector<Finding> JudgeServer(
    const std::string& address, const std::string& scene,
    const std::string& version,
    const absl::StatusOr<std::vector<relocalizer::SceneDescription>>& scenes,
    double round_trip_s) {
  if (!scenes.ok()) {
    const bool is_other = absl::IsUnimplemented(scenes.status());
    return {{.what = "server",
             .verdict = Verdict::kFail,
             .found = absl::StrCat(address, ": ", scenes.status().message()),
             .mend = is_other
                         ? "what answers there is no Treeline server, or one "
                           "of another version"
                         : "start treeline-server there, or mend the network; "
                           "the robot drives without, but finds itself "
                           "worse"}};
  }
  Finding reached{.what = "server",
                  .verdict = Verdict::kOk,
                  .found = absl::StrFormat("%s answers in %.0f ms", address,
                                           1000 * round_trip_s),
                  .mend = ""};
  if (round_trip_s > kSlowServer_s) {
    reached.verdict = Verdict::kWarn;
    reached.mend = "the network is slow: a lost robot stands for longer";
  }
  std::vector<Finding> findings = {std::move(reached)};
  std::vector<std::string> names;
  const relocalizer::SceneDescription* found = nullptr;
  for (const relocalizer::SceneDescription& one : *scenes) {
    names.push_back(one.name);
    if (one.name == scene) found = &one;
  }
  Finding there{.what = "server: scene",
                .verdict = Verdict::kFail,
                .found = absl::StrCat(
                    "no scene '", scene, "'; there are: ",
                    names.empty() ? "none" : absl::StrJoin(names, ", ")),
                .mend =
                    "train and publish the map's scene (treeline train "
                    "--map BUNDLE), or give --scene"};
  if (found == nullptr) {
    findings.push_back(std::move(there));
    return findings;
  }
  there.found =
      absl::StrCat(scene, " is ", found->state,
                   found->failure.empty() ? "" : ": ", found->failure);
  if (found->state == "READY" || found->state == "UNLOADED" ||
      found->state == "LOADING") {
    there.verdict = Verdict::kOk;
    there.mend.clear();
  } else {
    there.mend = "the server's log has the cause; publish the scene again";
  }
  findings.push_back(std::move(there));
  if (!found->model.has_value()) return findings;
  const std::string& theirs = found->model->software_version;
  Finding versions{.what = "server: version",
                   .verdict = Verdict::kOk,
                   .found = absl::StrCat("the scene was trained with ", theirs,
                                         ", this robot runs ", version),
                   .mend = ""};
  if (theirs != version) {
    versions.verdict = Verdict::kWarn;
    versions.mend = "install the same version on the server and the robot";
  }
  findings.push_back(std::move(versions));
  return findings;
}

Finding JudgeDisk(const std::string& path,
                  const absl::StatusOr<uint64_t>& free_bytes) {
  Finding finding{
      .what = "disk", .verdict = Verdict::kFail, .found = "", .mend = ""};
  if (!free_bytes.ok()) {
    finding.found = std::string(free_bytes.status().message());
    finding.mend = "give a folder that is there";
    return finding;
  }
  finding.found = absl::StrCat(*free_bytes / kMiB, " MiB are free at ", path);
  if (*free_bytes >= kLittleDisk) {
    finding.verdict = Verdict::kOk;
    return finding;
  }
  if (*free_bytes >= kNoDisk) finding.verdict = Verdict::kWarn;
  finding.mend = "make room: recordings need about 100 MiB a minute";
  return finding;
}

Finding JudgeClock(double unix_s, bool is_synchronised) {
  Finding finding{
      .what = "clock",
      .verdict = Verdict::kOk,
      .found = is_synchronised ? "synchronised" : "not synchronised",
      .mend = ""};
  if (unix_s < kEarliest_s) {
    finding.verdict = Verdict::kFail;
    finding.found = "it is years behind";
    finding.mend =
        "set it (timedatectl): certificates and tokens are refused otherwise";
  } else if (!is_synchronised) {
    finding.verdict = Verdict::kWarn;
    finding.mend =
        "switch on NTP (timedatectl set-ntp true), so that logs of robot and "
        "server fit; driving does not depend on it";
  }
  return finding;
}

Verdict WorstOf(const std::vector<Finding>& findings) {
  Verdict worst = Verdict::kOk;
  for (const Finding& finding : findings) {
    worst = std::max(worst, finding.verdict);
  }
  return worst;
}

std::string FindingsText(const std::vector<Finding>& findings) {
  std::string text;
  for (const Finding& finding : findings) {
    absl::StrAppendFormat(&text, "%-4s  %-18s %s\n",
                          VerdictName(finding.verdict), finding.what,
                          finding.found);
    if (!finding.mend.empty()) {
      absl::StrAppendFormat(&text, "      %-18s -> %s\n", "", finding.mend);
    }
  }
  return text;
}

std::string FindingsJson(const std::vector<Finding>& findings) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    list.push_back({{"what", finding.what},
                    {"verdict", VerdictName(finding.verdict)},
                    {"found", finding.found},
                    {"mend", finding.mend}});
  }
  const nlohmann::ordered_json json = {
      {"verdict", VerdictName(WorstOf(findings))}, {"findings", list}};
  return json.dump(2, ' ', /*ensure_ascii=*/false,
                   nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace treeline::doctor_app
