#include "nav_agent/app/map/map_command.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/relocalizer/connect_options.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/camera/calibration_json.h"
#include "common/dataset/dataset.h"
#include "nav_agent/app/map/calibrated_log.h"
#include "nav_agent/app/map/live_drive.h"
#include "nav_agent/app/map/live_questions.h"
#include "nav_agent/app/map/live_scene.h"
#include "nav_agent/app/map/map_from_log.h"
#include "nav_agent/app/map/map_from_rgbd.h"
#include "nav_agent/app/map/phase_line.h"
#include "nav_agent/app/relocalization/server_relocalization.h"
#include "nav_agent/app/ros/any_robot_file.h"
#include "nav_agent/recording/log_correction.h"
#include "nav_agent/ros_log/convert_log.h"

namespace treeline::map_app {
namespace {

constexpr const char* kFooter = R"(
Logs: agent logs of this program (docs/reference/agent-log.md), JSON as of the
Intel Research Lab, CARMEN, recordings of ROS (.mcap, .db3, .bag, the folder of
`ros2 bag record`; other topics than /scan and /odom: `log convert`). A log with
RGB-D frames gives a map in space and keyframes to train on; a laser alone gives
a plan. With --rgbd a camera alone makes the map; its floor, or the largest
level surface, says where up is.

With --live the drive is recorded, and mapped when it ends; BUNDLE/live.png shows
it meanwhile. The robot is pushed, or driven by its own remote control. Killed,
the recording lacks a second at most: map it with --log. Addresses are
/dev/ttyACM0, /dev/ttyUSB0@460800 or tcp:HOST:PORT.

A robot that is carried off while it maps, or whose laser was silent for long,
notices it: what it sees hangs on nothing until scans have found it in the map,
and is left out if they never do. With --server, the server that serves the
scene being learnt (--learn) is asked meanwhile; its answer counts once scans
confirm it, over a metre of the way.

BUNDLE then holds octomap.bt, levels/level-N.yaml and .pgm (where a robot may
drive), keyframes (a recording in the layout of 7-Scenes), trajectory.txt (TUM)
and map.png to look at; see docs/reference/map-bundle.md. From it, the scene's
model:

  treeline train --map BUNDLE --repository MODELS

Examples:
  treeline-agent simulate --world cafe --drive tour --camera-hz 5 \
      --record drive.tlog
  treeline-agent map --log drive.tlog --output cafe
  treeline-agent map --log intel.json --output intel --resolution 0.1
  treeline-agent map --log fr079.clf --calibrate --output fr079
  treeline-agent map --live --laser tcp:192.168.0.10 --base /dev/ttyUSB0 \
      --camera openni --output house
  treeline-agent map --live --ros2 robot.yaml --output house
  treeline-agent map --live --hardware robot.yaml --output house \
      --learn models --server 127.0.0.1:50051
  treeline-agent map --rgbd tum:rgbd_dataset_freiburg1_room --output room)";

constexpr double kDegPerRad = 180 / std::numbers::pi;

struct MapFlags {
  std::string log;
  bool is_live = false;
  LiveMappingOptions live;
  LiveSceneOptions scene;
  relocalizer::ConnectOptions server;
  dataset::DatasetOptions rgbd;
  std::string calibration;
  MapOptions map;
  double max_slope_deg = map.traversability.max_slope_rad * kDegPerRad;
  std::string odometry_noise = "auto";
  std::string robot;
  recording::LogCorrection correction;
  std::optional<core::MeasuredOdometryNoise> noise;
  bool calibrate = false;
  recording::RecordingTime::duration scan_delay{};
  bool no_loops = false;
  bool quiet = false;
};

void PrintSummary(const MapLogResult& result) {
  const mapping::RecordingMap& drive = result.drive;
  std::printf(
      "%lld scans, %lld of them keyscans; %lld loops closed; the front end "
      "takes %.2f ms a scan (median), %.2f ms (p99)\n",
      static_cast<long long>(drive.statistics.scans),
      static_cast<long long>(drive.statistics.keyscans),
      static_cast<long long>(drive.statistics.loops.accepted), drive.p50_ms,
      drive.p99_ms);
  std::printf(
      "of %lld scans that were matched, %lld did not match and %lld were found "
      "by a wide search; odometry was off by %.1f times (way) and %.1f times "
      "(turns) what was assumed\n",
      static_cast<long long>(drive.statistics.looked_at),
      static_cast<long long>(drive.statistics.unmatched),
      static_cast<long long>(drive.statistics.found_widely),
      drive.statistics.odometry_scale_m, drive.statistics.odometry_scale_rad);
  if (result.rmse_m.has_value()) {
    std::printf("%.3f m from the simulator's truth (RMSE of positions)\n",
                *result.rmse_m);
  }
  for (const std::string& warning : result.warnings) {
    std::fprintf(stderr, "warning: %s\n", warning.c_str());
  }
  if (result.frames_left_out > 0) {
    std::fprintf(stderr, "warning: %lld frames were left out\n",
                 static_cast<long long>(result.frames_left_out));
  }
}

void PrintSummary(const MapSummary& summary) {
  std::printf(
      "%lld voxels occupied, %lld free; %d levels, %d joins, %lld free cells; "
      "%d keyframes; under the wheels %d columns without ground, put to their "
      "height; %lld voxels of what moved, made free\nWritten to %s\n",
      static_cast<long long>(summary.occupied_voxels),
      static_cast<long long>(summary.free_voxels), summary.levels,
      summary.joins, static_cast<long long>(summary.free_cells),
      summary.keyframes, summary.driven_holes,
      static_cast<long long>(summary.moved_voxels), summary.folder.c_str());
}

// measured: of the robot's file.
void SetOdometryNoise(
    const std::string& name,
    const std::optional<core::MeasuredOdometryNoise>& measured,
    mapping::RecordingMapOptions& drive) {
  if (name != "auto") {
    mapping::OdometryNoise noise;
    noise.is_estimated = name == "learned";
    if (name == "gyroscope") noise = mapping::OdometryNoise::WithGyroscope();
    drive.slam.odometry = noise;
    drive.odometry_noise = noise;
  } else if (measured.has_value()) {
    for (mapping::OdometryNoise* usual :
         {&drive.slam.odometry, &drive.odometry_noise}) {
      *usual = mapping::OdometryNoise::AtLeast(*usual, *measured);
    }
  }
}

absl::StatusOr<MapLogResult> RunLog(const MapFlags& flags,
                                    const std::stop_token& stop) {
  MapLogOptions options;
  options.map = flags.map;
  SetOdometryNoise(flags.odometry_noise, flags.noise, options.drive);
  options.drive.slam.synchronous = true;
  options.drive.slam.loops.enabled = !flags.no_loops;
  options.scan_delay = flags.scan_delay;
  options.stop = stop;
  TL_ASSIGN_OR_RETURN(
      const ros_log::AsAgentLog log,
      ros_log::AsAgentLog::Open(flags.log, true, flags.correction));
  for (const std::string& note : log.notes()) {
    std::fprintf(stderr, "note: %s\n", note.c_str());
  }
  absl::StatusOr<MapLogResult> result;
  {
    PhaseLine line(flags.quiet);
    options.progress = [&line](const char* phase, double part) {
      line.Show(phase, part);
    };
    result = MapLog(log.path(), options);
  }
  TL_RETURN_IF_ERROR(result.status());
  PrintSummary(*result);
  PrintSummary(result->summary);
  if (result->drive.format == mapping::RecordingFormat::kLaserLog &&
      result->drive.base_from_laser.translation == geometry::Vec3{}) {
    std::fprintf(stderr,
                 "note: the log has its laser in the middle of the robot; "
                 "--calibrate finds where it is\n");
  }
  return result;
}

absl::Status RunCalibrated(MapFlags& flags, const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const CalibratedLog log,
                      CalibratedLog::Make(flags.log, flags.robot, stop));
  std::fprintf(stderr, "%s", log.summary().c_str());
  if (flags.odometry_noise == "auto" && !log.has_gyroscope()) {
    flags.odometry_noise = "learned";
  }
  flags.noise = log.noise();
  flags.log = log.path();
  flags.scan_delay = log.scan_delay();
  return RunLog(flags, stop).status();
}

void PrintSummary(const MapRgbdResult& result) {
  const rgbd_slam::RgbdSlamStatistics& slam = result.slam.statistics;
  std::printf(
      "%d frames: %d tracked, %d lost, found again %d times; %d loops closed, "
      "%d of %d parts joined; tracking takes %.1f ms a frame (median), %.1f ms "
      "(p99)\n",
      slam.frames, slam.tracked, slam.lost, slam.relocalized, slam.loops,
      slam.joined_submaps, slam.submaps, result.slam.tracking_p50_ms,
      result.slam.tracking_p99_ms);
  if (!result.upright.has_surface) {
    std::fprintf(stderr,
                 "warning: there is no large level surface; up is where most "
                 "pictures have it\n");
  }
}

absl::Status RunRgbd(const MapFlags& flags, const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const dataset::Dataset dataset,
                      dataset::Dataset::Open(flags.rgbd));
  MapRgbdOptions options;
  options.map = flags.map;
  options.slam.slam.seed = flags.map.seed;
  options.slam.slam.closes_loops = !flags.no_loops;
  options.stop = stop;
  if (!flags.calibration.empty()) {
    TL_ASSIGN_OR_RETURN(const std::string json,
                        base::ReadFile(flags.calibration));
    absl::StatusOr<camera::RgbdCalibration> calibration =
        camera::CalibrationFromJson(json);
    if (!calibration.ok()) {
      return base::Annotate(calibration.status(), flags.calibration);
    }
    calibration->pose_sensor = dataset.calibration().pose_sensor;
    options.slam.calibration = *calibration;
  }
  absl::StatusOr<MapRgbdResult> result;
  {
    PhaseLine line(flags.quiet);
    options.progress = [&line](const char* phase, double part) {
      line.Show(phase, part);
    };
    result = MapRgbd(dataset, options);
  }
  TL_RETURN_IF_ERROR(result.status());
  PrintSummary(*result);
  PrintSummary(result->summary);
  return absl::OkStatus();
}

void PrintLine(const std::string& line) {
  std::fprintf(stderr, "%s\n", line.c_str());
}

void PrintStatus(const LiveMapStatus& status) {
  std::string line = absl::StrFormat(
      "%d scans, %d frames, %.1f MB", status.scans, status.frames,
      static_cast<double>(status.log_bytes) / 1e6);
  if (status.map_from_base.has_value()) {
    const geometry::Vec3 at =
        status.map_from_base->world_from_camera.translation;
    absl::StrAppendFormat(&line, "; at (%.1f, %.1f), height %.2f m", at.x, at.y,
                          at.z);
  }
  if (status.is_lost) {
    absl::StrAppend(&line, "; carried off, and not found yet");
  }
  if (!status.silent.empty()) absl::StrAppend(&line, "; ", status.silent);
  std::fprintf(stderr, "%s\n", line.c_str());
}

void PrintScene(const LiveSceneStatus& status) {
  std::fprintf(stderr,
               "Handed %lld frames to the learner, %lld left out without a "
               "place, %lld without room; corrected %lld times, at last by up "
               "to %.3f m\n",
               static_cast<long long>(status.frames),
               static_cast<long long>(status.without_place),
               static_cast<long long>(status.not_handed_over),
               static_cast<long long>(status.corrections), status.moved_m);
  if (status.frames == 0) {
    std::fprintf(stderr,
                 "warning: no scene was learnt; that takes pictures with "
                 "depth\n");
  }
}

void PrintQuestions(const LiveQuestionStatus& status) {
  if (status.asked == 0) return;
  std::fprintf(stderr,
               "Asked the server %lld times where the robot is; %lld answers "
               "came, %lld of them could be right\n",
               static_cast<long long>(status.asked),
               static_cast<long long>(status.answered),
               static_cast<long long>(status.suggested));
}

absl::StatusOr<std::unique_ptr<LiveScene>> OpenScene(const MapFlags& flags) {
  LiveSceneOptions options = flags.scene;
  options.scene = flags.map.SceneName();
  options.folder = flags.map.folder + "/learning";
  options.log = flags.map.folder + "/learning.log";
  options.keyframe_m = flags.map.keyframe_m;
  options.keyframe_rad = flags.map.keyframe_rad;
  options.say = PrintLine;
  return LiveScene::Create(options);
}

// Who is asked about a lost robot, of --server.
class Helpers {
 public:
  static absl::StatusOr<std::unique_ptr<Helpers>> Open(const MapFlags& flags) {
    auto helpers = std::make_unique<Helpers>();
    TL_ASSIGN_OR_RETURN(
        helpers->port_,
        relocalization::MakeServerRelocalization(
            flags.server, flags.map.SceneName(), helpers->clock_));
    LiveQuestionOptions options;
    options.say = PrintLine;
    helpers->questions_ =
        std::make_unique<LiveQuestions>(*helpers->port_, options);
    return helpers;
  }

  LiveQuestions& questions() { return *questions_; }

 private:
  base::SteadyClock clock_;
  std::unique_ptr<core::RelocalizationPort> port_;
  std::unique_ptr<LiveQuestions> questions_;
};

// Records a drive into the bundle's folder, and makes the map of it.
absl::Status RunLive(MapFlags& flags, const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(flags.live.Validate());
  TL_RETURN_IF_ERROR(flags.map.Validate());
  const std::string& robot =
      flags.live.ros2.empty() ? flags.live.hardware : flags.live.ros2;
  if (!robot.empty()) {
    // The recording tells of the robot itself.
    TL_ASSIGN_OR_RETURN(const ros_app::AnyRobotFile file,
                        ros_app::ReadAnyRobotFile(robot));
    flags.correction.sensors = file.robot.correction;
    flags.noise = file.robot.noise;
  }
  LiveMapOptions& live = flags.live.map;
  if (live.log_path.empty()) live.log_path = flags.map.folder + "/drive.tlog";
  if (std::filesystem::exists(live.log_path)) {
    return absl::AlreadyExistsError(absl::StrCat(
        live.log_path,
        " is there already, the recording of a drive: make its map with "
        "--log, or name another file with --record, or move it away"));
  }
  TL_RETURN_IF_ERROR(
      map_bundle::BeginMapBundle(flags.map.folder, flags.map.overwrite));
  SetOdometryNoise(flags.odometry_noise, flags.noise, live.drive);
  live.picture_path = flags.map.folder + "/live.png";
  live.drive.slam.loops.enabled = !flags.no_loops;
  flags.live.seed = flags.map.seed;
  if (!flags.quiet) {
    flags.live.status = PrintStatus;
    std::fprintf(stderr,
                 "Drive; Ctrl-C ends the drive and makes the map. To watch: "
                 "%s\n",
                 live.picture_path.c_str());
  }
  std::unique_ptr<LiveScene> scene;
  if (!flags.scene.repository.empty()) {
    TL_ASSIGN_OR_RETURN(scene, OpenScene(flags));
    live.scene = scene.get();
  }
  std::unique_ptr<Helpers> helpers;
  if (!flags.server.server.empty()) {
    TL_ASSIGN_OR_RETURN(helpers, Helpers::Open(flags));
    live.questions = &helpers->questions();
  }
  TL_RETURN_IF_ERROR(RecordLiveDrive(flags.live, stop));
  if (helpers != nullptr) PrintQuestions(helpers->questions().status());
  std::fprintf(stderr, "Recorded in %s\n", live.log_path.c_str());
  if (scene != nullptr) PrintScene(scene->status());
  flags.log = live.log_path;
  // The stop that ended the drive is not meant for the map.
  TL_ASSIGN_OR_RETURN(const MapLogResult result, RunLog(flags, {}));
  if (scene != nullptr && result.drive.robot.has_value()) {
    scene->Finish(result.drive.map_from_base,
                  result.drive.robot->base_from_camera, {});
    PrintScene(scene->status());
  }
  return absl::OkStatus();
}

absl::Status Run(MapFlags& flags, const std::stop_token& stop) {
  const int sources = static_cast<int>(!flags.log.empty()) +
                      static_cast<int>(!flags.rgbd.uri.empty()) +
                      static_cast<int>(flags.is_live);
  if (sources != 1) {
    return absl::InvalidArgumentError(
        "of what is the map made? Give one of --log FILE, --rgbd URI and "
        "--live");
  }
  flags.map.traversability.max_slope_rad = flags.max_slope_deg / kDegPerRad;
  if (flags.log.empty() && (flags.calibrate || !flags.robot.empty())) {
    return absl::InvalidArgumentError(
        "--robot and --calibrate are for --log; with --live, --hardware or "
        "--ros2 names the robot's file");
  }
  const bool has_camera = (flags.is_live && flags.live.camera != "none") ||
                          !flags.live.hardware.empty() ||
                          !flags.live.ros2.empty();
  if (!has_camera &&
      !(flags.scene.repository.empty() && flags.server.server.empty())) {
    return absl::InvalidArgumentError(
        "--learn and --server are for --live with a camera; of a map that is "
        "there, `treeline train --map` learns the scene");
  }
  if (flags.is_live) return RunLive(flags, stop);
  if (flags.calibrate) return RunCalibrated(flags, stop);
  if (!flags.robot.empty()) {
    TL_ASSIGN_OR_RETURN(const ros_app::AnyRobotFile file,
                        ros_app::ReadAnyRobotFile(flags.robot));
    flags.correction = file.Correction();
    flags.noise = file.robot.noise;
  }
  return flags.log.empty() ? RunRgbd(flags, stop)
                           : RunLog(flags, stop).status();
}

void AddServerFlags(CLI::App& command, MapFlags& flags) {
  command
      .add_option("--server", flags.server.server,
                  "--live: asked where the robot is when it was carried off: "
                  "the server that serves what --learn learns")
      ->type_name("HOST:PORT");
  command
      .add_option("--tls-ca", flags.server.tls.ca_file,
                  "--server: use TLS, and trust these authorities (PEM)")
      ->type_name("FILE");
  command
      .add_option("--token-file", flags.server.token_file,
                  "--server: a file with the bearer token")
      ->type_name("FILE");
}

}  // namespace

cli::Command AddMapCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("map", "Make a map of a drive: where a robot may go");
  command->footer(kFooter);
  auto flags = std::make_shared<MapFlags>();
  command->add_option("--log", flags->log, "A recorded drive")
      ->type_name("FILE");
  command
      ->add_option(
          "--rgbd", flags->rgbd.uri,
          "Or: a recording of an RGB-D camera, 7scenes:DIR or tum:DIR; "
          "its poses are not looked at")
      ->type_name("URI");
  command
      ->add_option("--color-camera", flags->rgbd.color_camera,
                   "Its colour camera, as MODEL,p1,p2,... with COLMAP's names")
      ->type_name("CAMERA");
  command
      ->add_option("--depth-camera", flags->rgbd.depth_camera,
                   "Its depth camera, in the same form (7scenes)")
      ->type_name("CAMERA");
  command
      ->add_option("--calibration", flags->calibration,
                   "How its depth and colour fit together: a file of `treeline "
                   "calibrate`")
      ->type_name("FILE");
  command->add_flag("--live", flags->is_live,
                    "Or: while the robot is driven; see below");
  command
      ->add_option("--simulate", flags->live.simulate,
                   "--live: a simulated robot drives through this world")
      ->type_name("WORLD");
  command
      ->add_option("--scenario", flags->live.scenario,
                   "--simulate: what happens to the robot on its tour, and "
                   "when (docs/reference/simulator.md)")
      ->type_name("FILE");
  command
      ->add_option("--pace", flags->live.pace,
                   "--simulate: simulated seconds in a real one")
      ->capture_default_str();
  command->add_option("--laser", flags->live.laser, "--live: a Hokuyo laser")
      ->type_name("ADDRESS");
  command->add_option("--base", flags->live.base, "--live: a Segway RMP100")
      ->type_name("ADDRESS");
  command
      ->add_option("--ros2", flags->live.ros2,
                   "--live: a robot that speaks ROS 2: its topics, frames and "
                   "measures (docs/reference/ros2-robot.md)")
      ->type_name("FILE");
  command
      ->add_option("--hardware", flags->live.hardware,
                   "--live: the devices and measures of a robot, instead of "
                   "--laser, --base and --camera")
      ->type_name("FILE");
  command
      ->add_option("--robot", flags->robot,
                   "--log: the robot that drove, with its calibration: a "
                   "file of a robot, of --hardware or of --ros2")
      ->type_name("FILE");
  command->add_flag("--calibrate", flags->calibrate,
                    "--log: calibrate the robot by the drive first, as "
                    "`treeline-agent calibrate` does");
  command
      ->add_option("--camera", flags->live.camera,
                   "--live: none, openni, or, with --simulate, simulated")
      ->type_name("NAME")
      ->capture_default_str();
  command
      ->add_option("--seconds", flags->live.seconds,
                   "--live: ends the drive; otherwise Ctrl-C does, or the end "
                   "of the simulated tour")
      ->type_name("N");
  command
      ->add_option("--record", flags->live.map.log_path,
                   "--live: where the drive is recorded (default: drive.tlog "
                   "in the bundle)")
      ->type_name("FILE");
  command
      ->add_option("--learn", flags->scene.repository,
                   "--live: learn the scene while the robot maps, into this "
                   "server's folder of models")
      ->type_name("MODELS");
  command
      ->add_option("--learner", flags->scene.learner,
                   "--learn: the program `treeline` (default: beside this one, "
                   "or in PATH)")
      ->type_name("PROGRAM");
  AddServerFlags(*command, *flags);
  command->add_option("--output", flags->map.folder, "The map bundle's folder")
      ->type_name("BUNDLE")
      ->required();
  command->add_flag("--overwrite", flags->map.overwrite,
                    "Replace the map that is there");
  command
      ->add_option("--name", flags->map.name,
                   "What the scene is called (default: as the folder)")
      ->type_name("NAME");
  const auto add = [command](const char* name, double& value,
                             const char* description, const char* unit) {
    command->add_option(name, value, description)
        ->type_name(unit)
        ->capture_default_str();
  };
  add("--resolution", flags->map.fusion.resolution_m, "Of voxels and cells",
      "M");
  add("--max-depth", flags->map.fusion.max_depth_m,
      "Depth beyond says only what is free", "M");
  command->add_flag("--keep-moved", flags->map.keep_moved,
                    "Leave in the map what moved while it was made");
  add("--keyframe-distance", flags->map.keyframe_m,
      "A frame is kept when the camera has moved so far", "M");
  add("--max-slope-deg", flags->max_slope_deg,
      "Ground this steep is not driven on", "DEG");
  add("--max-step", flags->map.traversability.max_step_m,
      "The highest step driven over", "M");
  add("--robot-height", flags->map.traversability.robot_height_m,
      "Room that is needed", "M");
  command->add_option("--seed", flags->map.seed, "Of all that is drawn")
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--odometry-noise", flags->odometry_noise,
                   "How far a laser log's odometry may be trusted: learned "
                   "from the log, or fixed as of wheels or of wheels with a "
                   "gyroscope; auto: gyroscope for agent logs, learned for "
                   "others, and no less than what the robot's file says")
      ->type_name("NAME")
      ->check(CLI::IsMember({"auto", "learned", "wheels", "gyroscope"}))
      ->capture_default_str();
  command->add_flag("--no-loops", flags->no_loops,
                    "Close no loops, to see what they are good for");
  command->add_flag("--quiet", flags->quiet, "Show no progress");
  return {command,
          [flags](const std::stop_token& stop) { return Run(*flags, stop); }};
}

}  // namespace treeline::map_app
