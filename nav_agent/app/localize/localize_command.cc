#include "nav_agent/app/localize/localize_command.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/check_heading.h"
#include "common/base/file.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "common/image/decode.h"
#include "nav_agent/app/localize/localization_run.h"
#include "nav_agent/app/ros/any_robot_file.h"
#include "nav_agent/core/doubtful_map.h"
#include "nav_agent/localization/laser_level_map.h"
#include "nav_agent/map_bundle/drivable_map.h"
#include "nav_agent/map_bundle/map_bundle.h"
#include "nav_agent/octomap/octree_file.h"
#include "nav_agent/recording/log_correction.h"
#include "nav_agent/recording/wean_map.h"
#include "nav_agent/ros_log/convert_log.h"
#include "nav_agent/traversability/traversability.h"
#include "simulation/runs/localize_world.h"
#include "simulation/worlds/world.h"

namespace treeline::localize_app {
namespace {

constexpr const char* kFooter = R"(
Maps: map_server's YAML and PGM, or a map of Wean Hall (.dat, .dat.gz): one flat
level. Or an OctoMap (.bt, .ot), or a synthetic world's name: all of its levels
and slopes. Logs: an agent log; JSON as of the Intel Research Lab, CARMEN, or
Wean Hall's, each of which may be compressed; a recording of ROS (.mcap, .db3,
.bag, the folder of `ros2 bag record`).
docs/explanation/localization.md says more.

Examples:
  treeline-agent localize --map wean.dat.gz --log robotdata1.log.gz --global \
      --json out.json --picture out.png
  treeline-agent localize --map level-0.yaml --log drive.log --initial 1,2,0.5
  treeline-agent localize --map house --log drive.tlog --global
  treeline-agent localize --world two-storey --log drive.tlog --initial-truth)";

constexpr double kDegPerRad = 180 / std::numbers::pi;

struct LocalizeFlags {
  std::string map;
  std::string octomap;
  std::string world;
  double resolution_m = 0.05;
  bool flat = false;
  std::string log;
  std::string robot;
  std::vector<double> initial;
  bool initial_truth = false;
  bool global = false;
  bool no_tilt = false;
  uint64_t seed = 0;
  std::string json;
  std::string picture;
  bool quiet = false;
};

// All levels of a voxel map; or, for comparison, the lowest one as a laser
// would see it if there were no slopes.
absl::StatusOr<LocalizationMap> LevelsOf(const octree::VoxelMap& voxels,
                                         double laser_height_m, bool flat) {
  TL_ASSIGN_OR_RETURN(const traversability::TraversableMap levels,
                      traversability::ExtractTraversableMap(voxels));
  LocalizationMap map;
  for (const traversability::TraversableLevel& level : levels.levels) {
    map.grids.push_back(
        localization::LaserSlice(voxels, level, laser_height_m));
  }
  if (flat) {
    map.grids.resize(1);
    return map;
  }
  TL_ASSIGN_OR_RETURN(localization::LaserLevelMap made,
                      localization::LaserLevelMap::Make(voxels, levels));
  map.levels =
      std::make_shared<const localization::LaserLevelMap>(std::move(made));
  return map;
}

bool IsWeanMap(const std::string& path) {
  return absl::EndsWith(path, ".dat") || absl::EndsWith(path, ".dat.gz");
}

absl::StatusOr<LocalizationMap> MapOf(const LocalizeFlags& flags,
                                      const RecordedDrive& drive) {
  const double laser_height_m = drive.base_from_laser.translation.z;
  if (!flags.map.empty()) {
    LocalizationMap map;
    if (IsWeanMap(flags.map)) {
      TL_ASSIGN_OR_RETURN(map.grids.emplace_back(),
                          recording::ReadWeanMap(flags.map));
      return map;
    }
    if (!map_bundle::IsFlatMapName(flags.map)) {
      // It says what to give instead.
      TL_RETURN_IF_ERROR(map_bundle::LoadDrivableMap(flags.map).status());
    }
    TL_ASSIGN_OR_RETURN(core::DoubtfulMap read,
                        core::ReadDoubtfulMap(flags.map));
    if (!read.doubt.empty()) {
      std::fprintf(stderr, "note: %s: %s\n", flags.map.c_str(),
                   read.doubt.c_str());
    }
    map.grids.push_back(std::move(read.grid));
    return map;
  }
  if (!drive.has_tilt) {
    return absl::InvalidArgumentError(
        "levels need an agent log: others do not tell the laser's height and "
        "the robot's tilt; give --map");
  }
  if (!flags.octomap.empty()) {
    TL_ASSIGN_OR_RETURN(const octree::VoxelMap voxels,
                        octree::ReadOctree(flags.octomap));
    auto map = LevelsOf(voxels, laser_height_m, flags.flat);
    if (!map.ok()) return base::Annotate(map.status(), flags.octomap);
    return map;
  }
  TL_ASSIGN_OR_RETURN(
      const worlds::World world,
      worlds::MakeWorld(flags.world, {.with_people = false, .paint = false}));
  TL_ASSIGN_OR_RETURN(const octree::VoxelMap voxels,
                      runs::VoxelsOfWorld(world, flags.resolution_m));
  return LevelsOf(voxels, laser_height_m, flags.flat);
}

// Where else it may be in the end.
void PrintDoubt(const localization::PlanarEstimate& last) {
  if (!last.in_doubt) return;
  std::printf("in doubt at the end: at (%.1f, %.1f) with a share of %.2f",
              last.map_from_base.translation.x,
              last.map_from_base.translation.y, last.place_share);
  constexpr size_t kNamed = 3;
  for (size_t i = 0; i < std::min(kNamed, last.other_places.size()); ++i) {
    const localization::PossiblePlace& other = last.other_places[i];
    std::printf(", or at (%.1f, %.1f) with %.2f",
                other.pose.map_from_base.translation.x,
                other.pose.map_from_base.translation.y, other.share);
  }
  std::printf("%s\n",
              last.other_places.size() > kNamed ? ", or elsewhere" : "");
}

void PrintSummary(const RecordedDrive& drive, const LocalizationMap& map,
                  const LocalizationResult& result) {
  std::string converged = "never sure of one place for good";
  if (result.converged_after_m.has_value()) {
    converged = absl::StrFormat("sure of its place after %.1f m",
                                *result.converged_after_m);
  }
  if (drive.refused_scans + drive.refused_readings + drive.damaged_bytes > 0) {
    std::printf(
        "Left out of the log: %lld scans, %lld wheel readings, %lld bytes\n",
        static_cast<long long>(drive.refused_scans),
        static_cast<long long>(drive.refused_readings),
        static_cast<long long>(drive.damaged_bytes));
  }
  std::printf(
      "%zu scans; %s\n%.1f %% of the beams end within %.1f m of the map's "
      "obstacles\nan update takes %.2f ms (median), %.2f ms (p99) of processor "
      "time\n",
      result.scans.size(), converged.c_str(), 100 * result.agreement,
      kAgreement_m, result.median_update_ms, result.p99_update_ms);
  if (!result.scans.empty()) PrintDoubt(result.scans.back().estimate);
  if (!result.errors.has_value()) return;
  const LocalizationErrors& errors = *result.errors;
  std::printf(
      "Against the truth, from there on (%zu scans): position RMSE %.3f m, p95 "
      "%.3f m, max %.3f m; heading RMSE %.2f, p95 %.2f, max %.2f degrees\n",
      errors.scans, errors.position_m.rmse, errors.position_m.p95,
      errors.position_m.max, kDegPerRad * errors.heading_rad.rmse,
      kDegPerRad * errors.heading_rad.p95, kDegPerRad * errors.heading_rad.max);
  if (errors.aligned_m.has_value()) {
    std::printf(
        "With the frames of map and truth aligned: position RMSE %.3f m, p95 "
        "%.3f m, max %.3f m\n",
        errors.aligned_m->rmse, errors.aligned_m->p95, errors.aligned_m->max);
  }
  if (map.levels != nullptr) {
    std::printf("%d levels; on the right one %.1f %% of the time\n",
                map.levels->levels(), 100 * errors.right_level);
  }
}

// A map bundle is its OctoMap, or, of a laser alone, its lowest level.
absl::Status ResolveBundle(LocalizeFlags& flags) {
  std::error_code error;
  if (!std::filesystem::is_directory(flags.map, error)) {
    return absl::OkStatus();
  }
  const absl::StatusOr<map_bundle::MapBundleManifest> manifest =
      map_bundle::ReadMapBundleManifest(flags.map);
  if (manifest.ok() && !manifest->planar_heights_m.empty()) {
    flags.map += absl::StrCat("/", map_bundle::kBundleLevels, "/level-0.yaml");
    return absl::OkStatus();
  }
  std::string octomap =
      absl::StrCat(flags.map, "/", map_bundle::kBundleOctomap);
  if (!std::filesystem::exists(octomap, error)) {
    // It says what to give instead.
    return map_bundle::LoadDrivableMap(flags.map).status();
  }
  flags.octomap = std::move(octomap);
  flags.map.clear();
  return absl::OkStatus();
}

absl::Status CheckFlags(const LocalizeFlags& flags) {
  if (static_cast<int>(flags.global) + static_cast<int>(flags.initial_truth) +
          static_cast<int>(!flags.initial.empty()) !=
      1) {
    return absl::InvalidArgumentError(
        "where does it begin? Give one of --initial X,Y,YAW[,HEIGHT], "
        "--initial-truth and --global");
  }
  if (static_cast<int>(!flags.map.empty()) +
          static_cast<int>(!flags.octomap.empty()) +
          static_cast<int>(!flags.world.empty()) !=
      1) {
    return absl::InvalidArgumentError(
        "give one of --map, --octomap and --world");
  }
  for (const std::string* path : {&flags.json, &flags.picture}) {
    if (!path->empty()) TL_RETURN_IF_ERROR(base::CheckWritable(*path));
  }
  return absl::OkStatus();
}

absl::StatusOr<LocalizationRunOptions> OptionsOf(const LocalizeFlags& flags,
                                                 const RecordedDrive& drive) {
  LocalizationRunOptions options;
  options.seed = flags.seed;
  options.use_tilt = !flags.no_tilt;
  if (!flags.initial.empty()) {
    TL_RETURN_IF_ERROR(base::CheckHeading("--initial", flags.initial[2]));
    options.initial_map_from_base =
        geometry::Rigid2{.translation = {flags.initial[0], flags.initial[1]},
                         .yaw_rad = flags.initial[2]};
    if (flags.initial.size() > 3) options.initial_height_m = flags.initial[3];
  }
  if (flags.initial_truth) {
    const std::optional<geometry::Rigid3>& truth =
        drive.scans.front().world_from_base;
    if (!truth.has_value()) {
      return absl::FailedPreconditionError(
          absl::StrCat(flags.log, " does not tell the truth"));
    }
    options.initial_map_from_base = geometry::PlanarPose(*truth);
    options.initial_height_m = truth->translation.z;
  }
  return options;
}

absl::Status Localize(LocalizeFlags& flags, const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(ResolveBundle(flags));
  TL_RETURN_IF_ERROR(CheckFlags(flags));
  recording::LogCorrection correction;
  std::optional<core::MeasuredOdometryNoise> noise;
  if (!flags.robot.empty()) {
    TL_ASSIGN_OR_RETURN(const ros_app::AnyRobotFile robot,
                        ros_app::ReadAnyRobotFile(flags.robot));
    correction = robot.Correction();
    noise = robot.robot.noise;
  }
  TL_ASSIGN_OR_RETURN(const ros_log::AsAgentLog log,
                      ros_log::AsAgentLog::Open(flags.log, false, correction));
  for (const std::string& note : log.notes()) {
    std::fprintf(stderr, "note: %s\n", note.c_str());
  }
  TL_ASSIGN_OR_RETURN(const RecordedDrive drive, ReadDrive(log.path()));
  TL_ASSIGN_OR_RETURN(const LocalizationMap map, MapOf(flags, drive));
  TL_ASSIGN_OR_RETURN(LocalizationRunOptions options, OptionsOf(flags, drive));
  if (noise.has_value()) {
    options.amcl.odometry = localization::OdometryNoise::Of(*noise);
  }
  absl::StatusOr<LocalizationResult> result;
  {
    base::Progress progress(
        "localizing", static_cast<int64_t>(drive.scans.size()), flags.quiet);
    result = LocalizeDrive(
        map, drive, options, [&progress] { progress.Add(1); }, stop);
  }
  TL_RETURN_IF_ERROR(result.status());
  PrintSummary(drive, map, *result);
  if (!flags.json.empty()) {
    TL_RETURN_IF_ERROR(
        base::WriteFileAtomically(flags.json, LocalizationJson(*result)));
  }
  if (flags.picture.empty()) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const std::string png,
                      image::EncodePng(DrawLocalization(map, drive, *result)));
  return base::WriteFileAtomically(flags.picture, png);
}

}  // namespace

cli::Command AddLocalizeCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("localize", "Follow a recorded drive on a map (AMCL)");
  command->footer(kFooter);
  auto flags = std::make_shared<LocalizeFlags>();
  command
      ->add_option("--map", flags->map,
                   "The level's map; or a map bundle, with all levels")
      ->type_name("YAML");
  command
      ->add_option("--octomap", flags->octomap,
                   "An OctoMap: all levels, with slopes")
      ->type_name("FILE");
  command
      ->add_option("--world", flags->world,
                   "A synthetic world as a perfect OctoMap")
      ->type_name("NAME");
  command
      ->add_option("--resolution", flags->resolution_m,
                   "Of the OctoMap of --world")
      ->type_name("M")
      ->capture_default_str();
  command->add_flag("--flat", flags->flat,
                    "Only the lowest level of an OctoMap, as if it had no "
                    "slopes: to compare");
  command->add_option("--log", flags->log, "Scans and odometry")
      ->type_name("FILE")
      ->required();
  command
      ->add_option("--robot", flags->robot,
                   "The robot that drove, with its calibration: a file of a "
                   "robot, of --hardware or of --ros2")
      ->type_name("FILE");
  command
      ->add_option("--initial", flags->initial,
                   "Where the drive begins, in m and rad; within half a metre")
      ->type_name("X,Y,YAW[,HEIGHT]")
      ->delimiter(',')
      ->expected(3, 4);
  command->add_flag("--initial-truth", flags->initial_truth,
                    "It begins about where the log's truth says");
  command->add_flag("--global", flags->global, "It may begin anywhere");
  command->add_flag("--no-tilt", flags->no_tilt,
                    "Take the robot to stand level always: to compare");
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

}  // namespace treeline::localize_app
