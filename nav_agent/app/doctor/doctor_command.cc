#include "nav_agent/app/doctor/doctor_command.h"

#include <sys/statvfs.h>
#include <sys/timex.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "client/relocalizer/grpc_relocalizer.h"
#include "common/base/interrupt.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "common/config/effective_config.h"
#include "nav_agent/app/calibrate/calibrate_run.h"
#include "nav_agent/app/doctor/doctor.h"
#include "nav_agent/app/doctor/doctor_ros2.h"
#include "nav_agent/app/hardware/robot_hardware.h"
#include "nav_agent/app/run/agent_config.h"
#include "nav_agent/map_bundle/drivable_map.h"

namespace treeline::doctor_app {
namespace {

constexpr const char* kFooter = R"(
Looks at what it is given: sensors and base with --hardware or --ros2 (the robot
does not move), the map with --map, the server with --server, all of them with
the --config of `treeline-agent run`; at clock and disk always. Every line is
ok, warn or fail, with what was found, and what to mend.

Examples:
  treeline-agent doctor --hardware robot.yaml --map house \
      --server reloc.local:50051
  treeline-agent doctor --ros2 robot.yaml
  treeline-agent doctor --config agent.yaml --json

Exit codes: 0 fit to drive (warnings included), 1 something fails, 2 wrong
usage.)";

struct DoctorFlags {
  std::string config;
  std::string hardware;
  std::string ros2;
  std::string drive;
  std::string map;
  std::string server;
  std::string scene;
  double listen_s = 3;
  bool json = false;
};

using Findings = std::vector<Finding>;

void Append(Findings more, Findings& findings) {
  for (Finding& finding : more) findings.push_back(std::move(finding));
}

double DepthShareOf(const image::Frame& frame) {
  if (!frame.depth.has_value() || frame.depth->values.empty()) return 0;
  int64_t measured = 0;
  for (const uint16_t value : frame.depth->values) {
    if (value != 0 && value != 65535) ++measured;
  }
  return static_cast<double>(measured) /
         static_cast<double>(frame.depth->values.size());
}

double BrightnessOf(const image::ColorImage& image) {
  if (image.rgb.empty()) return 0;
  int64_t sum = 0;
  for (const uint8_t value : image.rgb) sum += value;
  return static_cast<double>(sum) / static_cast<double>(image.rgb.size());
}

// Listens to all devices at the same time.
absl::Status ExamineHardware(const std::string& path, double listen_s,
                             const std::stop_token& stop, Findings& findings) {
  const absl::StatusOr<hardware::HardwareConfig> config =
      hardware::ReadHardwareConfig(path);
  if (!config.ok()) {
    findings.push_back(
        {.what = "hardware",
         .verdict = Verdict::kFail,
         .found = std::string(config.status().message()),
         .mend = "mend the file; docs/reference/agent.md has the keys"});
    return absl::OkStatus();
  }
  const base::SteadyClock clock;
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<hardware::RobotHardware> hardware,
                      hardware::RobotHardware::Open(*config, clock));
  std::vector<std::pair<core::RangeSensor*, HeardLaser>> lasers;
  lasers.emplace_back(&hardware->laser(), HeardLaser());
  if (hardware->rear_laser() != nullptr) {
    lasers.emplace_back(hardware->rear_laser(), HeardLaser());
    lasers.back().second.name = "rear laser";
  }
  HeardBase base;
  HeardCamera camera;
  const base::MonotonicTime start = clock.Now();
  // What comes while devices are being found does not count.
  const base::MonotonicTime end =
      start + std::chrono::duration_cast<base::MonotonicTime::duration>(
                  std::chrono::duration<double>(listen_s));
  while (clock.Now() < end && !stop.stop_requested()) {
    for (auto& [laser, heard] : lasers) {
      for (core::LaserScan& scan : laser->TakeScans()) {
        heard.scans.push_back(std::move(scan));
      }
    }
    for (const core::BaseReading& reading : hardware->base().TakeReadings()) {
      base.readings.push_back(reading);
    }
    if (hardware->camera() != nullptr) {
      for (const core::RgbdFrame& frame : hardware->camera()->TakeFrames()) {
        ++camera.frames;
        camera.depth_share = DepthShareOf(frame.frame);
        camera.brightness = BrightnessOf(frame.frame.color);
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const auto since = [](base::MonotonicTime from, base::MonotonicTime to) {
    return std::chrono::duration<double>(to - from).count();
  };
  for (auto& [laser, heard] : lasers) {
    heard.info = laser->Info();
    heard.health = laser->Health();
    heard.seconds =
        heard.scans.empty() ? listen_s : since(heard.scans[0].stamp, end);
    Append(JudgeLaser(heard), findings);
  }
  base.health = hardware->base().Health();
  base.seconds =
      base.readings.empty() ? listen_s : since(base.readings[0].stamp, end);
  Append(JudgeBase(base), findings);
  if (hardware->camera() == nullptr) {
    findings.push_back({.what = "camera",
                        .verdict = Verdict::kWarn,
                        .found = "the robot has none",
                        .mend = "without a camera a lost robot cannot ask the "
                                "server"});
    return absl::OkStatus();
  }
  camera.health = hardware->camera()->Health();
  camera.seconds = listen_s;
  Append(JudgeCamera(camera), findings);
  return absl::OkStatus();
}

// The scene's name, if the map has one.
std::string ExamineMap(const std::string& path, Findings& findings) {
  absl::StatusOr<map_bundle::DrivableMap> map =
      map_bundle::LoadDrivableMap(path);
  if (!map.ok()) {
    Append(JudgeMap(path, map.status()), findings);
    return "";
  }
  if (!map->warning.empty()) {
    findings.push_back({.what = "map: what is unknown",
                        .verdict = Verdict::kWarn,
                        .found = map->warning,
                        .mend = "change the YAML file"});
  }
  Append(
      JudgeMap(path, behavior::NavigatorMap{.voxels = std::move(map->voxels),
                                            .levels = std::move(map->levels)}),
      findings);
  return map->name;
}

absl::Status ExamineServer(const std::string& address, const std::string& scene,
                           const run_app::AgentConfig& config,
                           Findings& findings) {
  relocalizer::ConnectOptions connect;
  connect.server = address;
  connect.tls.ca_file = config.tls_ca;
  connect.token_file = config.token_file;
  TL_ASSIGN_OR_RETURN(
      const std::unique_ptr<relocalizer::Relocalizer> relocalizer,
      relocalizer::ConnectRelocalizer(connect));
  relocalizer::CallOptions options;
  options.timeout = std::chrono::seconds(5);
  const base::SteadyClock clock;
  // The first call connects; the second is the round trip.
  auto scenes = relocalizer->ListScenes(options);
  const base::MonotonicTime start = clock.Now();
  if (scenes.ok()) scenes = relocalizer->ListScenes(options);
  Append(JudgeServer(address, scene, base::Version(), scenes,
                     base::MillisecondsBetween(start, clock.Now()) / 1000),
         findings);
  return absl::OkStatus();
}

absl::Status ExamineCalibration(const std::string& drive,
                                const std::string& hardware,
                                const std::stop_token& stop,
                                Findings& findings) {
  const auto result =
      calibrate_app::RunCalibration({.log = drive, .robot = hardware}, stop);
  if (absl::IsCancelled(result.status())) return result.status();
  findings.push_back(JudgeCalibration(
      drive, result.ok()
                 ? absl::StatusOr<calibration::Calibration>(result->calibration)
                 : absl::StatusOr<calibration::Calibration>(result.status())));
  return absl::OkStatus();
}

void ExamineMachine(const std::string& folder, Findings& findings) {
  timex time{};
  const bool is_synchronised =
      adjtimex(&time) != TIME_ERROR && (time.status & STA_UNSYNC) == 0;
  findings.push_back(
      JudgeClock(static_cast<double>(std::time(nullptr)), is_synchronised));
  struct statvfs disk {};
  if (statvfs(folder.c_str(), &disk) != 0) {
    findings.push_back(JudgeDisk(folder, absl::NotFoundError(absl::StrCat(
                                             folder, ": ", strerror(errno)))));
    return;
  }
  findings.push_back(
      JudgeDisk(folder, uint64_t{disk.f_bavail} * uint64_t{disk.f_frsize}));
}

absl::Status Examine(DoctorFlags flags, const std::stop_token& stop) {
  Findings findings;
  run_app::AgentConfig config;
  if (!flags.config.empty()) {
    TL_ASSIGN_OR_RETURN(
        const config::EffectiveConfig effective,
        config::ResolveConfig(run_app::AgentConfigTable().settings(),
                              {.file = flags.config}));
    config = run_app::AgentConfigTable().Make(effective);
    if (flags.hardware.empty()) flags.hardware = config.hardware;
    if (flags.ros2.empty()) flags.ros2 = config.ros2;
    if (flags.map.empty()) flags.map = config.map;
    if (flags.server.empty()) flags.server = config.server;
    if (flags.scene.empty()) flags.scene = config.scene;
  }
  if (!flags.hardware.empty()) {
    TL_RETURN_IF_ERROR(
        ExamineHardware(flags.hardware, flags.listen_s, stop, findings));
  }
  if (!flags.ros2.empty()) {
    Append(ExamineRos2(flags.ros2, flags.listen_s, stop), findings);
  }
  if (!flags.drive.empty()) {
    TL_RETURN_IF_ERROR(
        ExamineCalibration(flags.drive, flags.hardware, stop, findings));
  }
  std::string scene;
  if (!flags.map.empty()) scene = ExamineMap(flags.map, findings);
  if (!flags.scene.empty()) scene = flags.scene;
  if (!flags.server.empty()) {
    TL_RETURN_IF_ERROR(ExamineServer(flags.server, scene, config, findings));
  }
  ExamineMachine(".", findings);
  if (stop.stop_requested()) return absl::CancelledError("interrupted");
  const std::string text =
      flags.json ? FindingsJson(findings) + "\n" : FindingsText(findings);
  std::printf("%s", text.c_str());
  if (WorstOf(findings) != Verdict::kFail) return absl::OkStatus();
  return absl::FailedPreconditionError("the robot is not ready to drive");
}

}  // namespace

cli::Command AddDoctorCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "doctor", "Check sensors, map, server and machine, and say what to mend");
  command->footer(kFooter);
  auto flags = std::make_shared<DoctorFlags>();
  command
      ->add_option("--config", flags->config, "Settings of treeline-agent run")
      ->type_name("FILE");
  command
      ->add_option("--hardware", flags->hardware,
                   "The robot's devices and measures")
      ->type_name("FILE");
  command
      ->add_option("--ros2", flags->ros2,
                   "A robot that speaks ROS 2 (docs/reference/ros2-robot.md)")
      ->type_name("FILE");
  command
      ->add_option("--drive", flags->drive,
                   "A recorded drive: whether the calibration in the file of "
                   "--hardware still fits it")
      ->type_name("LOG");
  command
      ->add_option("--map", flags->map,
                   "A map bundle, or a map of map_server (YAML)")
      ->type_name("MAP");
  command->add_option("--server", flags->server, "A relocalization server")
      ->type_name("HOST:PORT");
  command
      ->add_option("--scene", flags->scene,
                   "The map's scene there; without: the bundle's name")
      ->type_name("NAME");
  command
      ->add_option("--listen-s", flags->listen_s,
                   "How long the devices are listened to")
      ->type_name("SECONDS")
      ->capture_default_str()
      ->check(CLI::Range(0.5, 60.0));
  command->add_flag("--json", flags->json, "For programs");
  return {command, [flags](const std::stop_token& stop) {
            return Examine(*flags, stop);
          }};
}

}  // namespace treeline::doctor_app
