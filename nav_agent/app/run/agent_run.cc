#include "nav_agent/app/run/agent_run.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "client/relocalizer/connect_options.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "common/http/http_server.h"
#include "common/http/static_files.h"
#include "nav_agent/app/relocalization/server_relocalization.h"
#include "nav_agent/app/ros/agent_topics.h"
#include "nav_agent/app/run/agent_loop.h"
#include "nav_agent/app/run/agent_recorder.h"
#include "nav_agent/app/run/agent_robot.h"
#include "nav_agent/app/run/agent_tracing.h"
#include "nav_agent/app/run/navigator_setup.h"
#include "nav_agent/app/run/repeated_lines.h"
#include "nav_agent/app/run/ros_agent_robot.h"
#include "nav_agent/app/run/watched_sensors.h"
#include "nav_agent/bridge/foxglove/foxglove_server.h"
#include "nav_agent/map_bundle/drivable_map.h"
#include "nav_agent/mapless/mapless_navigator.h"
#include "nav_agent/service/agent_grpc_server.h"
#include "nav_agent/service/agent_info.h"
#include "nav_agent/service/http_api.h"
#include "nav_agent/zones/zone_masks.h"

namespace treeline::run_app {
namespace {

// Pictures for people.
constexpr auto kPictureInterval = std::chrono::milliseconds(200);
// A pose that somebody gives is about right.
constexpr double kStartStd_m = 0.25;
constexpr double kStartStd_rad = 0.2;
// For /healthz and /readyz alone.
constexpr int kHttpConnectionsForProbes = 4;
// While the laser has not said how it scans.
constexpr auto kLaserLookUp = std::chrono::milliseconds(50);
constexpr auto kLaserReport = std::chrono::seconds(5);

double ProcessorTime_s() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

bool HasSpoken(const core::RangeSensor& laser) {
  return laser.Info().beams > 0 ||
         laser.Health().state == core::DeviceState::kRunning;
}

std::optional<geometry::Vec2> PositionOf(
    const std::optional<agent_service::RequestedPose>& pose) {
  if (!pose.has_value()) return std::nullopt;
  return geometry::Vec2{pose->x_m, pose->y_m};
}

simulator::SimulatedBatteryOptions BatteryOf(const AgentConfig& config) {
  return {.standing_s = 8.0 / 3 * config.battery_lasts_s,
          .driving_s = config.battery_lasts_s,
          .charging_s = 0.5 * config.battery_lasts_s,
          .charge = config.battery_at / 100};
}

void SayTopics(const ros_app::RosRobot& robot, logging::ProgramLog& log) {
  const agent_report::TopicFacts facts = robot.Facts();
  log.Write(logging::LogLevel::kInfo,
            log.Event()
                .Word("event", "topics")
                .Integer("messages", facts.delivered)
                .Integer("refused", facts.refused)
                .Integer("clock_jumps", facts.clock_jumps)
                .Number("delivery_p50_ms", robot.Delivery_ms(0.5))
                .Number("delivery_p99_ms", robot.Delivery_ms(0.99))
                .Number("listening_s", robot.listening_s())
                .Number("processor_s", ProcessorTime_s()));
}

class AgentProgram {
 public:
  AgentProgram(const AgentConfig& config, logging::ProgramLog& log,
               const std::function<void(const std::string& line)>& announce)
      : config_(config), log_(log), announce_(announce) {}
  ~AgentProgram() { hub_.Close(); }

  absl::Status Run(const std::stop_token& stop);

 private:
  absl::Status LoadMap();
  // OK, and without a robot, if a stop was requested meanwhile.
  absl::Status MakeRobot(const std::stop_token& stop);
  absl::Status WatchDevices();
  // Puts lines into the log as warnings.
  std::function<void(const std::string& line)> Warner() {
    return [this](const std::string& line) {
      log_.Say(logging::LogLevel::kWarn, line);
    };
  }
  absl::Status ConnectServer();
  absl::Status Listen();
  absl::Status LetFoxgloveWatch();
  // Null: there is no camera.
  const agent_service::PictureKeeper* CameraPicture() const {
    return camera_ == nullptr ? nullptr : &camera_picture_;
  }
  // Those that were drawn, and masks.
  absl::Status ReadZones();
  // False: a stop was requested meanwhile.
  bool WaitForLasers(const std::stop_token& stop);
  absl::Status MakeNavigator();
  behavior::NavigatorDevices WatchedDevices();
  absl::Status GiveOrders();
  // What is done before the first step: in the log, and among the events.
  void TellStart(const std::string& what);
  void LogEvents(const std::vector<RepeatedLine>& lines);
  // A simulated robot stands where --start-at says.
  absl::Status PlaceRobot();
  // Steps wait for a simulation of somebody else's.
  bool FollowsSimulation() const {
    return ros_robot_ != nullptr && ros_robot_->config().use_sim_time;
  }

  const AgentConfig& config_;
  logging::ProgramLog& log_;
  const std::function<void(const std::string& line)>& announce_;
  const base::SteadyClock real_clock_;
  std::shared_ptr<const behavior::NavigatorMap> map_;
  agent_service::AgentInfo info_;
  std::unique_ptr<AgentRobot> robot_;
  // Of ROS 2; null: it is another.
  ros_app::RosRobot* ros_robot_ = nullptr;
  // ---- around the devices ----
  agent_service::PictureKeeper camera_picture_{kPictureInterval};
  agent_service::PictureKeeper query_picture_{std::chrono::milliseconds(0)};
  std::unique_ptr<AgentRecorder> recorder_;
  std::unique_ptr<WatchedSensors> sensors_;
  std::unique_ptr<agent_service::BackgroundCamera> camera_;
  // Null: there are no spans.
  std::unique_ptr<AgentTracing> tracing_;
  std::unique_ptr<core::RelocalizationPort> port_;
  std::unique_ptr<agent_service::WatchedServer> server_;
  // ---- around the navigator; what listens goes first ----
  agent_service::AgentHub hub_{agent_service::AgentHubOptions()};
  agent_service::AgentMetrics metrics_;
  std::unique_ptr<agent_service::StopFile> stops_;
  std::unique_ptr<agent_service::ZoneBook> zones_;
  std::unique_ptr<agent_service::RouteDesk> routes_;
  std::unique_ptr<agent_service::DockDesk> docks_;
  std::unique_ptr<agent_service::AgentCommands> commands_;
  std::unique_ptr<behavior::Navigator> navigator_;
  std::unique_ptr<agent_service::HttpApi> api_;
  std::unique_ptr<agent_service::AgentGrpcServer> grpc_;
  std::unique_ptr<http::HttpServer> http_;
  std::unique_ptr<foxglove::FoxgloveServer> foxglove_;
  std::unique_ptr<ros_app::AgentTopics> topics_;
};

absl::Status AgentProgram::LoadMap() {
  auto map = std::make_shared<behavior::NavigatorMap>();
  if (config_.map.empty() && config_.by_sight) {
    *map = BlankMap();
    info_.map_name = "nothing";
  } else if (config_.map.empty()) {
    TL_ASSIGN_OR_RETURN(*map, MapOfWorld(config_.simulate));
    info_.map_name = config_.simulate;
  } else {
    TL_ASSIGN_OR_RETURN(map_bundle::DrivableMap read,
                        map_bundle::LoadDrivableMap(config_.map));
    if (!read.warning.empty()) {
      log_.Say(logging::LogLevel::kWarn,
               absl::StrCat(config_.map, ": ", read.warning));
    }
    info_.map_name = read.name;
    map->voxels = std::move(read.voxels);
    map->levels = std::move(read.levels);
  }
  map_ = std::move(map);
  return absl::OkStatus();
}

absl::Status AgentProgram::MakeRobot(const std::stop_token& stop) {
  if (!config_.ros2.empty()) {
    TL_ASSIGN_OR_RETURN(
        std::unique_ptr<RosAgentRobot> robot,
        RosAgentRobot::Open(config_.ros2, real_clock_, Warner(), announce_));
    ros_robot_ = &robot->robot();
    robot_ = std::move(robot);
    return ros_robot_->WaitUntilKnown(stop);
  }
  if (config_.hardware.empty()) {
    TL_ASSIGN_OR_RETURN(const worlds::WorldOptions world,
                        config_.SimulatedWorld());
    TL_ASSIGN_OR_RETURN(const core::RobotDescription model,
                        core::ReadRobot(config_.robot));
    TL_ASSIGN_OR_RETURN(const std::optional<agent_service::RequestedPose> start,
                        ParseRequestedPose(config_.start_at, "--start-at"));
    TL_ASSIGN_OR_RETURN(
        robot_, MakeSimulatedRobot({.world = config_.simulate,
                                    .world_options = world,
                                    .seed = static_cast<uint64_t>(config_.seed),
                                    .camera_hz = config_.camera_hz,
                                    .robot = model,
                                    .has_rear_laser = config_.rear_laser,
                                    .map_begins_at_start = !config_.map.empty(),
                                    .start_at = PositionOf(start),
                                    .battery = BatteryOf(config_)}));
    return absl::OkStatus();
  }
  TL_ASSIGN_OR_RETURN(const hardware::HardwareConfig hardware,
                      hardware::ReadHardwareConfig(config_.hardware));
  TL_ASSIGN_OR_RETURN(robot_, MakeRealRobot(hardware));
  return absl::OkStatus();
}

absl::Status AgentProgram::WatchDevices() {
  if (!config_.record.empty()) {
    TL_ASSIGN_OR_RETURN(
        recorder_,
        AgentRecorder::Open(config_.record, robot_->model(), real_clock_,
                            [this](const absl::Status& status) {
                              log_.Say(logging::LogLevel::kError,
                                       absl::StrCat("the recording ends: ",
                                                    status.message()));
                            }));
  }
  const behavior::NavigatorDevices raw = robot_->Devices();
  sensors_ = std::make_unique<WatchedSensors>(
      raw.laser, raw.odometry, robot_->correction(), recorder_.get());
  core::RgbdCamera* camera = raw.camera;
  if (camera == nullptr) return absl::OkStatus();
  camera_ = std::make_unique<agent_service::BackgroundCamera>(
      *camera, [this, camera](const core::RgbdFrame& frame) {
        camera_picture_.Keep(frame);
        if (recorder_ != nullptr) recorder_->Add(camera->Calibration(), frame);
      });
  return absl::OkStatus();
}

absl::Status AgentProgram::ConnectServer() {
  if (config_.server.empty()) return absl::OkStatus();
  if (camera_ == nullptr) {
    log_.Say(logging::LogLevel::kWarn,
             "there is no camera: the server cannot be asked anything");
    return absl::OkStatus();
  }
  TL_ASSIGN_OR_RETURN(tracing_, AgentTracing::Start(config_, log_));
  relocalizer::ConnectOptions connect;
  connect.server = config_.server;
  connect.tls.ca_file = config_.tls_ca;
  connect.token_file = config_.token_file;
  TL_ASSIGN_OR_RETURN(
      port_,
      relocalization::MakeServerRelocalization(
          connect, config_.scene.empty() ? info_.map_name : config_.scene,
          robot_->clock(),
          tracing_ == nullptr ? nullptr : &tracing_->recovery()));
  server_ =
      std::make_unique<agent_service::WatchedServer>(*port_, query_picture_);
  return absl::OkStatus();
}

absl::Status AgentProgram::Listen() {
  info_.version = base::Version();
  info_.robot = robot_->model();
  info_.map = map_;
  info_.is_simulated = robot_->simulation() != nullptr;
  info_.world = robot_->world();
  info_.places = robot_->places();
  info_.server = config_.server;
  stops_ = config_.state_dir.empty()
               ? std::make_unique<agent_service::StopFile>()
               : std::make_unique<agent_service::StopFile>(config_.state_dir);
  if (const std::optional<std::string> why = stops_->why()) {
    log_.Say(
        logging::LogLevel::kWarn,
        absl::StrCat("the robot starts stopped, until it is released: ", *why));
  }
  TL_RETURN_IF_ERROR(ReadZones());
  TL_ASSIGN_OR_RETURN(routes_, agent_service::RouteDesk::Open(
                                   static_cast<int>(map_->levels.levels.size()),
                                   config_.state_dir));
  TL_ASSIGN_OR_RETURN(std::unique_ptr<agent_service::DockBook> docks,
                      agent_service::DockBook::Open(map_, config_.state_dir));
  docks_ = std::make_unique<agent_service::DockDesk>(
      std::move(docks), robot_->model(), config_.Charge(), robot_->contacts());
  commands_ = std::make_unique<agent_service::AgentCommands>(
      hub_, info_, robot_->simulation(), stops_.get(), zones_.get(),
      routes_.get(), docks_.get());
  if (!config_.listen.empty()) {
    TL_ASSIGN_OR_RETURN(
        grpc_,
        agent_service::AgentGrpcServer::Start(
            *commands_, {.listen = config_.listen,
                         .insecure_any_address = config_.insecure_any_address,
                         .max_streams = config_.max_streams,
                         .report = Warner()}));
    announce_("grpc on " + grpc_->address());
  }
  TL_RETURN_IF_ERROR(LetFoxgloveWatch());
  if (config_.http_listen.empty()) return absl::OkStatus();
  agent_service::HttpApiOptions options;
  options.max_streams = config_.max_streams;
  options.page_folder = config_.page_dir.empty()
                            ? http::FindPageFolder("page", TREELINE_BUILT_PAGE)
                            : config_.page_dir;
  TL_RETURN_IF_ERROR(options.Validate());
  const agent_service::PictureKeeper* query =
      server_ == nullptr ? nullptr : &query_picture_;
  api_ = std::make_unique<agent_service::HttpApi>(
      *commands_, metrics_, CameraPicture(), query, options, real_clock_);
  http::HttpServerOptions http;
  http.listen = config_.http_listen;
  http.insecure_any_address = config_.insecure_any_address;
  http.max_body_mib = 1;
  // Streams, and a few more for each.
  http.max_connections = 8 * config_.max_streams;
  http.max_probe_connections = kHttpConnectionsForProbes;
  TL_ASSIGN_OR_RETURN(http_, http::HttpServer::Start(http, *api_, real_clock_));
  announce_(absl::StrCat("page on http://", http_->address(), "/"));
  if (options.page_folder.empty()) {
    log_.Say(logging::LogLevel::kWarn,
             "the operator's page is not built; its API answers");
  }
  return absl::OkStatus();
}

absl::Status AgentProgram::LetFoxgloveWatch() {
  if (config_.foxglove_listen.empty()) return absl::OkStatus();
  foxglove::FoxgloveServerOptions options;
  options.listen = config_.foxglove_listen;
  options.insecure_any_address = config_.insecure_any_address;
  options.max_viewers = config_.max_streams;
  options.origins = absl::StrSplit(config_.foxglove_origins, ',');
  TL_ASSIGN_OR_RETURN(
      foxglove_, foxglove::FoxgloveServer::Start(info_, hub_, CameraPicture(),
                                                 options, real_clock_));
  announce_(absl::StrCat("foxglove on ws://", foxglove_->address()));
  return absl::OkStatus();
}

absl::Status AgentProgram::ReadZones() {
  agent_service::ZoneBookOptions options = {
      .masks = {},
      .full_mps =
          std::min(config_.max_forward_mps, robot_->model().max_forward_mps),
      .folder = config_.state_dir};
  if (!config_.zone_masks.empty()) {
    TL_ASSIGN_OR_RETURN(options.masks,
                        zones::ReadZoneMasks(config_.zone_masks));
  }
  TL_ASSIGN_OR_RETURN(zones_, agent_service::ZoneBook::Open(map_, options));
  return absl::OkStatus();
}

bool AgentProgram::WaitForLasers(const std::stop_token& stop) {
  const behavior::NavigatorDevices devices = robot_->Devices();
  base::MonotonicTime next_report = real_clock_.Now() + kLaserReport;
  RepeatedLines reports;
  while (!stop.stop_requested()) {
    const bool knows_front = HasSpoken(devices.laser);
    const core::RangeSensor* rear = devices.rear_laser;
    if (knows_front && (rear == nullptr || HasSpoken(*rear))) return true;
    if (real_clock_.Now() >= next_report) {
      next_report += kLaserReport;
      const absl::Status cause =
          (knows_front ? *rear : devices.laser).Health().cause;
      for (const RepeatedLine& line : reports.Next(
               "laser", absl::StrCat("waiting for the ",
                                     knows_front ? "rear " : "", "laser: ",
                                     cause.ok() ? "nothing has been heard of it"
                                                : cause.message()))) {
        log_.Say(logging::LogLevel::kWarn, line.text);
      }
    }
    // A simulated one begins with its time.
    robot_->Advance(std::chrono::milliseconds(25));
    std::this_thread::sleep_for(kLaserLookUp);
  }
  return false;
}

behavior::NavigatorDevices AgentProgram::WatchedDevices() {
  const behavior::NavigatorDevices raw = robot_->Devices();
  return {
      .laser = sensors_->laser(),
      .odometry = sensors_->odometry(),
      .base = raw.base,
      .rear_laser = raw.rear_laser,
      .camera = camera_ == nullptr ? nullptr : &sensors_->Corrected(*camera_),
      .server = server_.get()};
}

absl::Status AgentProgram::MakeNavigator() {
  if (config_.by_sight) {
    mapless::MaplessOptions options = SightOptionsOf(config_);
    if (!map_->levels.levels.empty()) {
      options.known = {map_->levels.levels.front().grid};
    }
    TL_ASSIGN_OR_RETURN(navigator_, mapless::MakeMaplessNavigator(
                                        robot_->model(), WatchedDevices(),
                                        options, robot_->clock()));
    return absl::OkStatus();
  }
  absl::StatusOr<std::unique_ptr<behavior::Navigator>> navigator =
      behavior::Navigator::Create(*map_, robot_->model(), WatchedDevices(),
                                  NavigatorOptionsOf(config_, *robot_),
                                  robot_->clock());
  if (!navigator.ok()) {
    return base::Annotate(navigator.status(),
                          config_.map.empty() ? config_.simulate : config_.map);
  }
  navigator_ = *std::move(navigator);
  return absl::OkStatus();
}

void AgentProgram::TellStart(const std::string& what) {
  hub_.AddEvent(0, "start", what);
  LogEvents({{.kind = "start", .text = what}});
}

void AgentProgram::LogEvents(const std::vector<RepeatedLine>& lines) {
  for (const RepeatedLine& line : lines) {
    log_.Write(logging::LogLevel::kInfo,
               log_.Event().Word("event", line.kind).Text("text", line.text));
  }
}

absl::Status AgentProgram::PlaceRobot() {
  TL_ASSIGN_OR_RETURN(std::optional<agent_service::RequestedPose> start,
                      ParseRequestedPose(config_.start_at, "--start-at"));
  if (!start.has_value() || robot_->simulation() == nullptr) {
    return absl::OkStatus();
  }
  TL_ASSIGN_OR_RETURN(const core::LevelPose pose,
                      commands_->OnLevel(*start, "--start-at"));
  TL_RETURN_IF_ERROR(base::Annotate(robot_->simulation()->Kidnap(pose).status(),
                                    "--start-at"));
  // It was no kidnap.
  robot_->TakeIncidents();
  return absl::OkStatus();
}

absl::Status AgentProgram::GiveOrders() {
  commands_->StopAsKept(*navigator_);
  TL_RETURN_IF_ERROR(navigator_->SetZones(zones_->contents().map));
  if (const absl::Status offered = routes_->Offer(robot_->clock().Now());
      !offered.ok()) {
    log_.Say(logging::LogLevel::kWarn, std::string(offered.message()));
  }
  TL_ASSIGN_OR_RETURN(std::optional<agent_service::RequestedPose> start,
                      ParseRequestedPose(config_.start_at, "--start-at"));
  const std::optional<geometry::Rigid3> truth = robot_->TrueMapFromBase();
  if (start.has_value()) {
    TL_ASSIGN_OR_RETURN(const core::LevelPose pose,
                        commands_->OnLevel(*start, "--start-at"));
    TL_RETURN_IF_ERROR(agent_service::AgentCommands::SetPoseNow(
        *navigator_, pose, kStartStd_m, kStartStd_rad));
  } else if (truth.has_value() && !config_.find_yourself) {
    // A simulated robot begins where everybody knows.
    TL_RETURN_IF_ERROR(agent_service::AgentCommands::SetPoseNow(
        *navigator_, commands_->NearestLevel(*truth), kStartStd_m,
        kStartStd_rad));
  } else if (!config_.find_yourself) {
    log_.Say(logging::LogLevel::kInfo,
             "the robot waits to be told where it is: give --start-at, "
             "--find-yourself, or an initial pose on the page");
  }
  TL_ASSIGN_OR_RETURN(const std::optional<agent_service::RequestedPose> goal,
                      ParseRequestedPose(config_.goal, "--goal"));
  if (!goal.has_value()) return absl::OkStatus();
  const absl::Status set = commands_->SetGoalNow(*navigator_, {*goal}).status();
  if (stops_->why().has_value()) {
    log_.Say(logging::LogLevel::kWarn, set.message());
    return absl::OkStatus();
  }
  return set;
}

absl::Status AgentProgram::Run(const std::stop_token& stop) {
  const base::MonotonicTime began = real_clock_.Now();
  TellStart(config_.map.empty() ? "makes the map" : "reads the map");
  TL_RETURN_IF_ERROR(LoadMap());
  log_.Write(
      logging::LogLevel::kInfo,
      log_.Event()
          .Word("event", "map")
          .Text("name", info_.map_name)
          .Integer("levels", static_cast<int64_t>(map_->levels.levels.size()))
          .Integer("voxels", map_->voxels.CountOccupied()));
  TellStart(config_.simulate.empty() ? "opens the robot's devices"
                                     : "makes the simulated world");
  TL_RETURN_IF_ERROR(MakeRobot(stop));
  if (stop.stop_requested()) return absl::OkStatus();
  TL_RETURN_IF_ERROR(WatchDevices());
  TL_RETURN_IF_ERROR(ConnectServer());
  TL_RETURN_IF_ERROR(Listen());
  TL_RETURN_IF_ERROR(PlaceRobot());
  TellStart("waits for the lasers");
  if (!WaitForLasers(stop)) return absl::OkStatus();
  TellStart("prepares localization and planning on the map");
  TL_RETURN_IF_ERROR(MakeNavigator());
  TL_RETURN_IF_ERROR(GiveOrders());
  TellStart(absl::StrFormat("is ready after %.1f s",
                            base::SecondsBetween(began, real_clock_.Now())));
  if (ros_robot_ != nullptr) {
    TL_ASSIGN_OR_RETURN(topics_, ros_app::AgentTopics::Start(
                                     *ros_robot_, *commands_, Warner()));
  }
  RepeatedLines events;
  AgentLoop loop(
      *robot_, *navigator_, *commands_, metrics_,
      {.camera = camera_.get(),
       .server = server_.get(),
       .battery = &sensors_->battery()},
      {.control_hz = kControlHz,
       .speed = FollowsSimulation() ? std::numeric_limits<double>::infinity()
                                    : config_.speed,
       .duration_s = config_.duration},
      real_clock_,
      [this, &events](const std::string& kind, const std::string& text) {
        if (tracing_ != nullptr) tracing_->recovery().OnEvent(kind, text);
        LogEvents(events.Next(kind, text));
      });
  announce_("driving");
  loop.Run(stop);
  LogEvents(events.Finish());
  // Whoever watches is told before the drivers end.
  hub_.Close();
  topics_.reset();
  if (recorder_ != nullptr) TL_RETURN_IF_ERROR(recorder_->Flush());
  log_.Write(logging::LogLevel::kInfo,
             log_.Event()
                 .Word("event", "stopped")
                 .Integer("steps", loop.steps())
                 .Integer("missed_deadlines", loop.missed_deadlines()));
  if (ros_robot_ != nullptr) SayTopics(*ros_robot_, log_);
  // The robot stands.
  if (tracing_ != nullptr) tracing_->Stop();
  return absl::OkStatus();
}

}  // namespace

absl::Status RunAgent(
    const AgentConfig& config, logging::ProgramLog& log,
    const std::function<void(const std::string& line)>& announce,
    const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(config.Validate());
  AgentProgram program(config, log, announce);
  return program.Run(stop);
}

}  // namespace treeline::run_app
