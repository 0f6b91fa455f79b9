#include "nav_agent/app/run/agent_config.h"

#include <cmath>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/check_heading.h"
#include "common/base/status_macros.h"
#include "simulation/worlds/rearrange.h"

namespace treeline::run_app {
namespace {

using Table = config::ConfigTable<AgentConfig>;

absl::Status CheckTraceEndpoint(const config::ConfigValue& value) {
  const std::string& text = std::get<std::string>(value);
  return text.empty() ? absl::OkStatus() : tracing::CheckEndpoint(text);
}

absl::Status CheckTraceHeaders(const config::ConfigValue& value) {
  return tracing::ParsePairs(
             absl::StrJoin(std::get<std::vector<std::string>>(value), ","))
      .status();
}

void AddRobot(Table& table) {
  table.Add(&AgentConfig::simulate,
            {.name = "simulate",
             .value_name = "WORLD",
             .help = "Simulated robot in this world: cafe, lab, two-storey, "
                     "office-floor, seed:N, or a world file"});
  table.Add(&AgentConfig::hardware,
            {.name = "hardware",
             .value_name = "FILE",
             .help = "Real robot: YAML file with laser, base, camera and "
                     "measures (docs/reference/agent.md)"});
  table.Add(&AgentConfig::ros2,
            {.name = "ros2",
             .value_name = "FILE",
             .help = "Robot that speaks ROS 2: YAML file with topics, frames "
                     "and measures (docs/reference/ros2-robot.md)"});
  table.Add(&AgentConfig::speed,
            {.name = "speed",
             .value_name = "FACTOR",
             .help = "Simulated seconds for each real second",
             .min = 0.01,
             .max = 1000});
  table.Add(&AgentConfig::people,
            {.name = "people", .help = "People walk about in the simulation"});
  table.Add(&AgentConfig::light,
            {.name = "light",
             .value_name = "NAME",
             .help = "Light of the simulated world: day, sunny, lamps-off, "
                     "evening, half-lamps, night; '': that of its file, or "
                     "day"});
  table.Add(&AgentConfig::rearranged,
            {.name = "rearranged",
             .value_name = "SEED:SHARE",
             .help = "Share (0 to 1) of the simulated world's furniture that "
                     "is missing or was moved since it was mapped"});
  table.Add(&AgentConfig::camera_hz,
            {.name = "camera_hz",
             .help = "Frames a second of the simulated camera; 0: no camera",
             .min = 0,
             .max = 30});
  table.Add(&AgentConfig::rear_laser,
            {.name = "rear_laser",
             .help = "The simulated robot has a second laser that looks back"});
  table.Add(
      &AgentConfig::robot,
      {.name = "robot",
       .value_name = "NAME",
       .help = "The simulated robot: rmp100, jackal, turtlebot3, or a file "
               "(docs/reference/robots.md)"});
  table.Add(&AgentConfig::record,
            {.name = "record",
             .value_name = "FILE",
             .help = "Agent log to record the sensors into"});
  table.Add(&AgentConfig::state_dir,
            {.name = "state_dir",
             .value_name = "DIR",
             .help = "Folder where a stop, drawn zones, routes and docks are "
                     "kept, so that a restart finds them; default: a restart "
                     "forgets them"});
  table.Add(&AgentConfig::battery_at,
            {.name = "battery_at",
             .value_name = "PERCENT",
             .help = "Charge of the simulated robot's battery at first",
             .min = 0,
             .max = 100});
  table.Add(&AgentConfig::battery_lasts_s,
            {.name = "battery_lasts_s",
             .value_name = "SECONDS",
             .help = "Driving, it is empty after so long, standing after eight "
                     "thirds of that; a charger fills it in half of it",
             .min = 10,
             .max = 1e6});
}

void AddPlace(Table& table) {
  table.Add(&AgentConfig::map,
            {.name = "map",
             .value_name = "MAP",
             .help = "Map bundle of `treeline-agent map`, or a map of "
                     "map_server (YAML); with simulate and without map: the "
                     "world's own perfect map"});
  table.Add(&AgentConfig::zone_masks,
            {.name = "zone_masks",
             .value_name = "FILE",
             .help = "Keep-out and speed zones as mask files: YAML file that "
                     "lists them (docs/reference/zones.md)"});
  table.Add(&AgentConfig::start_at,
            {.name = "start_at",
             .value_name = "X,Y,YAW[,LEVEL]",
             .help = "Start pose of the robot in the map (m, rad)"});
  table.Add(
      &AgentConfig::find_yourself,
      {.name = "find_yourself",
       .help =
           "The start pose is unknown: find it with the server and the laser"});
  table.Add(&AgentConfig::goal, {.name = "goal",
                                 .value_name = "X,Y,YAW[,LEVEL]",
                                 .help = "First goal (m, rad)"});
}

void AddServer(Table& table) {
  table.Add(&AgentConfig::server,
            {.name = "server",
             .value_name = "HOST:PORT",
             .help = "Relocalization server for a lost robot; several replicas "
                     "separated by commas, in quotes"});
  table.Add(&AgentConfig::scene,
            {.name = "scene",
             .value_name = "NAME",
             .help = "Name of the map's scene on the server; default: the "
                     "bundle's name"});
  table.Add(
      &AgentConfig::tls_ca,
      {.name = "tls_ca",
       .value_name = "FILE",
       .help = "Use TLS for the server and trust these authorities, PEM"});
  table.Add(&AgentConfig::token_file,
            {.name = "token_file",
             .value_name = "FILE",
             .help = "File with the bearer token for the server"});
  table.Add(
      &AgentConfig::trace_endpoint,
      {.name = "trace_endpoint",
       .value_name = "URL",
       .help = "Where spans of the robot's recoveries are posted to by OTLP, "
               "like http://collector:4318/v1/traces; '': where "
               "OpenTelemetry's variables say, or else there are none",
       .check = CheckTraceEndpoint,
       .secrecy = config::Secrecy::kAddress});
  table.Add(&AgentConfig::trace_headers,
            {.name = "trace_headers",
             .value_name = "NAME=VALUE,...",
             .help = "Headers to send with them, such as a collector's key",
             .check = CheckTraceHeaders,
             .secrecy = config::Secrecy::kSecret});
  table.Add(&AgentConfig::trace_ratio,
            {.name = "trace_ratio",
             .help = "Share of the recoveries that is recorded, 0 to 1; -1: as "
                     "OTEL_TRACES_SAMPLER says, or else all",
             .min = -1,
             .max = 1});
}

void AddListening(Table& table) {
  table.Add(&AgentConfig::listen,
            {.name = "listen",
             .value_name = "HOST:PORT",
             .help = "Address of the gRPC listener; '': none"});
  table.Add(&AgentConfig::http_listen,
            {.name = "http_listen",
             .value_name = "HOST:PORT",
             .help = "Address of the operator's page and its API; '': none"});
  table.Add(&AgentConfig::foxglove_listen,
            {.name = "foxglove_listen",
             .value_name = "HOST:PORT",
             .help = "Address at which Foxglove may watch, over its WebSocket "
                     "protocol; Foxglove looks at 127.0.0.1:8765; '': none"});
  table.Add(&AgentConfig::foxglove_origins,
            {.name = "foxglove_origins",
             .value_name = "ORIGIN,...",
             .help = "Web pages that may watch there, by their origins; '*': "
                     "any. Programs that are no pages always may"});
  table.Add(&AgentConfig::insecure_any_address,
            {.name = "insecure_any_address",
             .help = "Allow addresses that other machines reach; anybody who "
                     "reaches them can drive the robot"});
  table.Add(&AgentConfig::page_dir,
            {.name = "page_dir",
             .value_name = "DIR",
             .help = "Folder of the page's files; default: where they were "
                     "built or installed"});
  table.Add(
      &AgentConfig::max_streams,
      {.name = "max_streams",
       .help =
           "Maximum number of pages that watch at a time, and of gRPC streams",
       .min = 1,
       .max = 1000});
}

void AddDriving(Table& table) {
  table.Add(&AgentConfig::by_sight,
            {.name = "by_sight",
             .help = "Drive by what the lasers see and the wheels count, "
                     "without localization; what a map shows on its lowest "
                     "level is known beforehand, without map nothing is"});
  table.Add(&AgentConfig::planner,
            {.name = "planner",
             .help = "Global planner (docs/explanation/planning.md)"});
  table.Add(&AgentConfig::max_forward_mps,
            {.name = "max_forward_mps",
             .help = "Maximum forward speed, m/s",
             .min = 0.05,
             .max = 3});
  table.Add(
      &AgentConfig::inflation_m,
      {.name = "inflation_m",
       .help =
           "Clearance beside the robot that it keeps where there is room, m",
       .min = 0.05,
       .max = 2});
  table.Add(&AgentConfig::goal_tolerance_m,
            {.name = "goal_tolerance_m",
             .help = "Distance to the goal at which it counts as reached, m",
             .min = 0.02,
             .max = 1});
  table.Add(&AgentConfig::goal_tolerance_rad,
            {.name = "goal_tolerance_rad",
             .help = "Heading error at which the goal counts as reached, rad",
             .min = 0.02,
             .max = 3.2});
  table.Add(&AgentConfig::laser_timeout_s,
            {.name = "laser_timeout_s",
             .help = "Silence after which a laser counts as lost, s",
             .min = 0.05,
             .max = 5});
  table.Add(&AgentConfig::odometry_timeout_s,
            {.name = "odometry_timeout_s",
             .help = "Silence after which odometry counts as lost, s",
             .min = 0.05,
             .max = 5});
}

void AddCharging(Table& table) {
  table.Add(&AgentConfig::charge_below,
            {.name = "charge_below",
             .value_name = "PERCENT",
             .help = "Charge of the battery below which the robot drives to a "
                     "dock by itself, if there is one; 0: never",
             .min = 0,
             .max = 99});
  table.Add(&AgentConfig::charge_until,
            {.name = "charge_until",
             .value_name = "PERCENT",
             .help = "Charge with which it goes on with what it did",
             .min = 1,
             .max = 100});
}

void AddProgram(Table& table) {
  table.Add(
      &AgentConfig::duration,
      {.name = "duration",
       .value_name = "SECONDS",
       .help = "End after this much of the robot's time; 0: run until stopped",
       .min = 0,
       .max = 1e7});
  table.Add(&AgentConfig::seed, {.name = "seed",
                                 .help = "Seed of all random numbers",
                                 .min = 0,
                                 .max = 1e15});
  table.Add(&AgentConfig::log_level,
            {.name = "log_level",
             .help = "Lowest level that is logged",
             .choices = {"debug", "info", "warn", "error", "off"}});
  table.Add(&AgentConfig::log_format,
            {.name = "log_format",
             .help = "Lines of key=value, or one JSON object a line",
             .choices = {"text", "json"}});
}

}  // namespace

const config::ConfigTable<AgentConfig>& AgentConfigTable() {
  // Immutable; made by the first who asks.
  static const auto* const table = [] {
    auto* made = new Table;
    AddRobot(*made);
    AddPlace(*made);
    AddServer(*made);
    AddListening(*made);
    AddDriving(*made);
    AddCharging(*made);
    AddProgram(*made);
    return made;
  }();
  return *table;
}

absl::StatusOr<tracing::TracingOptions> AgentConfig::Tracing() const {
  tracing::TracingOptions options = otel;
  TL_RETURN_IF_ERROR(tracing::ApplySettings(trace_endpoint, trace_headers,
                                            trace_ratio, options));
  return options;
}

absl::StatusOr<std::optional<agent_service::RequestedPose>> ParseRequestedPose(
    const std::vector<std::string>& numbers, absl::string_view flag) {
  if (numbers.empty()) return std::nullopt;
  agent_service::RequestedPose pose;
  const bool is_read =
      (numbers.size() == 3 || numbers.size() == 4) &&
      absl::SimpleAtod(numbers[0], &pose.x_m) &&
      absl::SimpleAtod(numbers[1], &pose.y_m) &&
      absl::SimpleAtod(numbers[2], &pose.yaw_rad) &&
      (numbers.size() == 3 || absl::SimpleAtoi(numbers[3], &pose.level));
  if (!is_read || !std::isfinite(pose.x_m) || !std::isfinite(pose.y_m) ||
      !std::isfinite(pose.yaw_rad)) {
    return absl::InvalidArgumentError(absl::StrCat(
        flag, " ", absl::StrJoin(numbers, ","),
        " is not a pose; give X,Y,YAW or X,Y,YAW,LEVEL in m and rad"));
  }
  TL_RETURN_IF_ERROR(base::CheckHeading(
      absl::StrCat(flag, " ", absl::StrJoin(numbers, ",")), pose.yaw_rad));
  return pose;
}

absl::StatusOr<worlds::WorldOptions> AgentConfig::SimulatedWorld() const {
  worlds::WorldOptions options;
  options.with_people = people;
  if (!light.empty()) {
    TL_ASSIGN_OR_RETURN(options.lighting, building::ParseLighting(light));
  }
  if (!rearranged.empty()) {
    TL_ASSIGN_OR_RETURN(options.rearranged,
                        worlds::ParseRearrangement(rearranged));
  }
  return options;
}

absl::Status AgentConfig::Validate() const {
  if (int{simulate.empty()} + int{hardware.empty()} + int{ros2.empty()} != 2) {
    return absl::InvalidArgumentError(
        "give one of --simulate WORLD, --hardware FILE and --ros2 FILE");
  }
  if (map.empty() && simulate.empty() && !by_sight) {
    return absl::InvalidArgumentError(
        "a real robot needs --map MAP (treeline-agent map makes one; the YAML "
        "of a map of map_server will do), or "
        "--by-sight");
  }
  if (simulate.empty() && speed != 1) {
    return absl::InvalidArgumentError(
        "--speed is for simulations: a real robot has its own time");
  }
  if (find_yourself && !start_at.empty()) {
    return absl::InvalidArgumentError(
        "give either --start-at or --find-yourself");
  }
  if (find_yourself && by_sight) {
    return absl::InvalidArgumentError(
        "--by-sight finds no place; leave --find-yourself out");
  }
  if (!zone_masks.empty() && by_sight) {
    return absl::InvalidArgumentError(
        "--by-sight keeps to no zones; leave --zone-masks out");
  }
  TL_RETURN_IF_ERROR(Charge().Validate());
  TL_RETURN_IF_ERROR(SimulatedWorld().status());
  TL_RETURN_IF_ERROR(ParseRequestedPose(start_at, "--start-at").status());
  return ParseRequestedPose(goal, "--goal").status();
}

}  // namespace treeline::run_app
