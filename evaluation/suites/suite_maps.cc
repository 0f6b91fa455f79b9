#include "evaluation/suites/suite_maps.h"

#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/base/child_process.h"
#include "common/base/file.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "nav_agent/app/map/map_from_log.h"
#include "nav_agent/map_bundle/map_bundle.h"
#include "simulation/runs/simulation_run.h"
#include "simulation/simulator/scenario_player.h"

namespace treeline::suites {
namespace {

namespace fs = std::filesystem;

// A quarter of what `treeline train` takes by itself: minutes rather than a
// quarter of an hour for the five worlds.
constexpr const char* kFramesPerTree = "250";
constexpr const char* kSamplesPerFrame = "500";

std::string FolderOf(const SuiteMapOptions& options) {
  return absl::StrCat(options.cache, "/", SuiteSceneName(options));
}

absl::StatusOr<simulator::RobotPlacement> DriveStart(
    const std::string& world_name) {
  simulator::Scenario scenario;
  scenario.world = world_name;
  scenario.world_options = {.with_people = false, .threads = 1, .paint = false};
  TL_RETURN_IF_ERROR(simulator::MakeWorldOf(scenario).status());
  return scenario.options.start;
}

absl::Status RecordDrive(const SuiteMapOptions& options, const std::string& log,
                         const std::stop_token& stop) {
  runs::SimulationRunOptions run;
  simulator::Scenario& scenario = run.scenario;
  scenario.world = options.world;
  scenario.world_options = {.lighting = options.map_lighting,
                            .with_people = false};
  scenario.options.seed = kSurveySeed;
  scenario.options.sensors.camera_hz = kSurveyCamera_hz;
  scenario.options.threads = 0;
  run.tour.emplace();
  run.tour->options.look_around_every_m = kSurveyEvery_m;
  run.record_path = log;
  TL_ASSIGN_OR_RETURN(worlds::World world, simulator::MakeWorldOf(scenario));
  TL_ASSIGN_OR_RETURN(
      const std::unique_ptr<simulator::Simulator> simulator,
      simulator::Simulator::Create(std::move(world), scenario.options));
  TL_ASSIGN_OR_RETURN(
      const runs::SimulationResult result,
      runs::RunSimulation(
          *simulator, run, [](double /*simulated_s*/) {}, stop));
  if (!options.quiet)
    std::fputs(runs::SimulationSummary(result).c_str(), stderr);
  if (result.tour_done) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      "the mapping drive through ", options.world,
      " did not come to its end; `treeline-agent simulate --world ",
      options.world, " --drive survey --picture FILE.png` shows why"));
}

absl::Status MapDriveOf(const SuiteMapOptions& options,
                        const std::stop_token& stop) {
  const std::string log = FolderOf(options) + "/drive.tlog";
  TL_RETURN_IF_ERROR(base::MakeParentFolder(log));
  TL_RETURN_IF_ERROR(RecordDrive(options, log, stop));
  map_app::MapLogOptions map;
  map.map.folder = SuiteBundleFolder(options);
  map.map.overwrite = true;
  map.map.name = SuiteSceneName(options);
  map.drive.slam.synchronous = true;
  map.stop = stop;
  map.progress = [](const char* /*phase*/, double /*part*/) {};
  TL_ASSIGN_OR_RETURN(const map_app::MapLogResult result,
                      map_app::MapLog(log, map));
  if (!options.quiet) {
    std::fprintf(stderr, "%s: %d keyframes, %d levels, %.3f m RMSE\n",
                 options.world.c_str(), result.summary.keyframes,
                 result.summary.levels, result.rmse_m.value_or(-1));
  }
  std::error_code ignored;
  fs::remove(log, ignored);
  return absl::OkStatus();
}

absl::StatusOr<map_bundle::MapBundle> BundleOf(const SuiteMapOptions& options,
                                               const std::stop_token& stop) {
  const std::string folder = SuiteBundleFolder(options);
  if (!map_bundle::ReadMapBundleManifest(folder).ok()) {
    if (!options.quiet) {
      std::fprintf(stderr, "mapping %s: a drive, once, into %s\n",
                   options.world.c_str(), folder.c_str());
    }
    TL_RETURN_IF_ERROR(MapDriveOf(options, stop));
  }
  return map_bundle::LoadMapBundle(folder);
}

}  // namespace

std::string SuiteWorldName(const std::string& world) {
  return absl::StrReplaceAll(world, {{":", "-"}, {"/", "-"}});
}

std::string SuiteSceneName(const SuiteMapOptions& options) {
  const std::string name = SuiteWorldName(options.world);
  if (options.map_lighting == building::Lighting::kDay) return name;
  return absl::StrCat(name, "-in-",
                      building::LightingName(options.map_lighting));
}

std::string SuiteBundleFolder(const SuiteMapOptions& options) {
  return FolderOf(options) + "/bundle";
}

absl::StatusOr<std::shared_ptr<const SuitePlace>> PlaceForSuite(
    const SuiteMapOptions& options, const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(
      worlds::World world,
      worlds::MakeWorld(options.world, {.rearranged = options.rearranged,
                                        .lighting = options.lighting,
                                        .with_people = options.with_people,
                                        .paint = options.paint}));
  if (!options.is_driven && options.rearranged.share > 0) {
    TL_ASSIGN_OR_RETURN(const worlds::World mapped,
                        worlds::MakeWorld(options.world, {.with_people = false,
                                                          .paint = false}));
    return SuitePlace::MakePerfect(std::move(world), mapped,
                                   options.robot_radius_m);
  }
  if (!options.is_driven) {
    return SuitePlace::MakePerfect(std::move(world), options.robot_radius_m);
  }
  TL_ASSIGN_OR_RETURN(map_bundle::MapBundle bundle, BundleOf(options, stop));
  TL_ASSIGN_OR_RETURN(const simulator::RobotPlacement start,
                      DriveStart(options.world));
  const geometry::Rigid3 world_from_map = {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0, start.yaw_rad}),
      .translation = {start.position.x, start.position.y, start.height_m}};
  TL_ASSIGN_OR_RETURN(
      std::shared_ptr<const SuitePlace> place,
      SuitePlace::Make(std::move(world),
                       {.voxels = std::move(bundle.voxels),
                        .levels = std::move(bundle.levels)},
                       world_from_map.Inverse(), options.robot_radius_m));
  std::printf("The map of %s has %.1f %% of the places in it.\n",
              options.world.c_str(), 100 * place->MappedShare());
  return place;
}

absl::StatusOr<std::string> ModelsForSuite(const SuiteMapOptions& options,
                                           const std::stop_token& stop) {
  const std::string models = options.cache + "/models";
  const std::string scene = SuiteSceneName(options);
  std::error_code error;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(absl::StrCat(models, "/", scene), error)) {
    // What an interrupted training leaves is no model.
    if (fs::exists(entry.path() / "model.treeline", error)) return models;
  }
  TL_RETURN_IF_ERROR(BundleOf(options, stop).status());
  TL_ASSIGN_OR_RETURN(const std::string program,
                      base::SiblingProgram("treeline"));
  if (!options.quiet) {
    std::fprintf(stderr, "training %s\n", scene.c_str());
  }
  fs::create_directories(models, error);
  TL_ASSIGN_OR_RETURN(
      const std::unique_ptr<base::ChildProcess> training,
      base::ChildProcess::Start(
          {program, "train", "--map", SuiteBundleFolder(options),
           "--repository", models, "--scene", scene, "--frames-per-tree",
           kFramesPerTree, "--samples-per-frame", kSamplesPerFrame},
          FolderOf(options) + "/train.log"));
  TL_RETURN_IF_ERROR(training->Wait(stop));
  return models;
}

}  // namespace treeline::suites
