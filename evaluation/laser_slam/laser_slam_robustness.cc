// How laser SLAM bears worse data: a table over degradations of a log, or of a
// drive through a synthetic office.
//
//   laser_slam_robustness --office 1
//   laser_slam_robustness --log fr079.clf --relations fr079.relations.txt
//
// Prints errors of relative poses (Kuemmerle et al. 2009), scans that did not
// match, loops and processor time (all threads). --maps FOLDER writes the map
// of each row, --poses FILE "stamp x y yaw" of the last row.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "evaluation/laser_slam/degraded_log.h"
#include "evaluation/laser_slam/synthetic_office.h"
#include "nav_agent/core/map_file.h"
#include "nav_agent/mapping/run_laser_slam.h"
#include "nav_agent/mapping/trajectory_score.h"
#include "nav_agent/recording/relations.h"

namespace treeline::laser_slam {
namespace {

constexpr double kDegPerRad = 180 / std::numbers::pi;

struct Flags {
  std::string log;
  std::string relations;
  std::optional<uint64_t> office;
  std::string only;
  std::string maps;
  std::string poses;
  bool no_loops = false;
};

struct Source {
  recording::LaserLog log;
  std::vector<recording::PoseRelation> relations;
  std::optional<OfficeDrive> office;
};

absl::StatusOr<Source> Open(const Flags& flags) {
  Source source;
  if (flags.office.has_value()) {
    source.office = DriveThroughOffice({.seed = *flags.office});
    source.log = source.office->log;
    return source;
  }
  TL_ASSIGN_OR_RETURN(source.log, recording::ReadLaserLog(flags.log));
  if (!flags.relations.empty()) {
    TL_ASSIGN_OR_RETURN(source.relations,
                        recording::ReadRelations(flags.relations));
  }
  return source;
}

absl::Status WritePoses(const mapping::LaserSlamResult& result,
                        const std::string& path) {
  std::string text;
  for (const mapping::TrajectoryPose& pose : result.trajectory) {
    const geometry::Rigid2& p = pose.map_from_base;
    absl::StrAppend(&text, recording::FormatRecordingTime(pose.stamp), " ",
                    p.translation.x, " ", p.translation.y, " ", p.yaw_rad,
                    "\n");
  }
  return base::WriteFileAtomically(path, text);
}

void PrintRow(const std::string& name, const mapping::LaserSlamResult& result,
              const std::vector<recording::PoseRelation>& relations,
              double processor_s) {
  const mapping::LaserSlamStatistics& s = result.statistics;
  std::printf("%-34s", name.c_str());
  const auto score =
      mapping::ScoreRelations(result.trajectory, relations, {.max_gap_s = 0});
  if (score.ok()) {
    const auto spread = [](const base::ErrorSummary& e) {
      return std::sqrt(std::max(0.0, e.rmse * e.rmse - e.mean * e.mean));
    };
    const base::ErrorSummary& t = score->translation_m;
    const base::ErrorSummary& r = score->rotation_rad;
    std::printf(" %5d  %.4f +- %.4f  med %.4f  max %6.3f  %6.3f +- %6.3f",
                score->used, t.mean, spread(t), t.median, t.max,
                r.mean * kDegPerRad, spread(r) * kDegPerRad);
  } else {
    std::printf(" %5s", "-");
  }
  std::printf("  unmatched %lld/%lld  loops %lld-%lld  %.1f s\n",
              static_cast<long long>(s.unmatched),
              static_cast<long long>(s.looked_at),
              static_cast<long long>(s.loops.accepted),
              static_cast<long long>(s.loops.dropped), processor_s);
  std::fflush(stdout);
}

absl::Status RunRow(const Source& source, const Degradation& degradation,
                    const Flags& flags) {
  TL_ASSIGN_OR_RETURN(const recording::LaserLog log,
                      Degraded(source.log, degradation));
  const std::vector<recording::PoseRelation> relations =
      source.office.has_value() ? TrueRelations(*source.office, log)
                                : source.relations;
  mapping::RunLaserSlamOptions options;
  options.slam.synchronous = true;
  options.slam.loops.enabled = !flags.no_loops;
  const std::clock_t start = std::clock();
  TL_ASSIGN_OR_RETURN(const mapping::LaserSlamResult result,
                      mapping::RunLaserSlam(log, options));
  const double processor_s =
      static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  PrintRow(degradation.name, result, relations, processor_s);
  if (!flags.maps.empty()) {
    std::string name = degradation.name;
    for (char& c : name) c = std::isalnum(c) != 0 ? c : '-';
    TL_RETURN_IF_ERROR(core::WriteMap(
        result.grid, absl::StrCat(flags.maps, "/", name, ".yaml")));
  }
  if (flags.poses.empty()) return absl::OkStatus();
  return WritePoses(result, flags.poses);
}

absl::Status Run(const Flags& flags) {
  TL_ASSIGN_OR_RETURN(const Source source, Open(flags));
  for (const Degradation& degradation : StandardDegradations()) {
    if (!absl::StrContains(degradation.name, flags.only)) continue;
    TL_RETURN_IF_ERROR(RunRow(source, degradation, flags));
  }
  return absl::OkStatus();
}

int Main(int argc, char** argv) {
  CLI::App app("Laser SLAM on logs that are made worse");
  Flags flags;
  app.add_option("--log", flags.log, "A laser log");
  app.add_option("--relations", flags.relations, "Its reference relations");
  app.add_option("--office", flags.office,
                 "Instead of a log: a synthetic office of this seed");
  app.add_option("--only", flags.only,
                 "Only degradations that have this in their name");
  app.add_option("--maps", flags.maps, "A folder for the maps");
  app.add_flag("--no-loops", flags.no_loops, "Close no loops");
  app.add_option("--poses", flags.poses, "A file for poses");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = Run(flags);
  if (status.ok()) return 0;
  std::cerr << status.message() << "\n";
  return 1;
}

}  // namespace
}  // namespace treeline::laser_slam

int main(int argc, char** argv) {
  return treeline::laser_slam::Main(argc, argv);
}
