#include "simulation/simulator/scenario_reader.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/yaml/yaml_node.h"

namespace treeline::simulator {
namespace {

constexpr double kMaxLength_m = 10000;
constexpr double kMaxTime_s = 1e6;

double Radians(double degrees) { return degrees * std::numbers::pi / 180; }

// {at: [x, y], yaw_deg: 0, height_m: 0}, other keys left to the caller.
absl::StatusOr<RobotPlacement> ReadPlacement(const yaml::YamlNode& node) {
  TL_ASSIGN_OR_RETURN(const std::vector<double> at,
                      node.Numbers("at", 2, -kMaxLength_m, kMaxLength_m));
  TL_ASSIGN_OR_RETURN(const double yaw_deg,
                      node.NumberOr("yaw_deg", 0, -360, 360));
  TL_ASSIGN_OR_RETURN(
      const double height_m,
      node.NumberOr("height_m", 0, -kMaxLength_m, kMaxLength_m));
  return RobotPlacement{.position = {at[0], at[1]},
                        .yaw_rad = Radians(yaw_deg),
                        .height_m = height_m};
}

// A place by name, or a placement.
absl::Status ReadPlace(const yaml::YamlNode& node, std::string& place,
                       std::optional<RobotPlacement>& placement) {
  TL_RETURN_IF_ERROR(node.CheckKeys({"place", "at", "yaw_deg", "height_m"}));
  if (node.Has("place") == node.Has("at")) {
    return node.Error("either 'place' or 'at' is needed");
  }
  if (node.Has("place")) {
    TL_ASSIGN_OR_RETURN(place, node.Text("place"));
    return absl::OkStatus();
  }
  TL_ASSIGN_OR_RETURN(placement, ReadPlacement(node));
  return absl::OkStatus();
}

using Action = decltype(ScenarioAction::what);

absl::StatusOr<Action> ReadDrive(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(
      node.CheckKeys({"forward_mps", "yaw_rate_radps", "for_s"}));
  DriveAction drive;
  TL_ASSIGN_OR_RETURN(drive.command.forward_mps,
                      node.NumberOr("forward_mps", 0, -10, 10));
  TL_ASSIGN_OR_RETURN(drive.command.yaw_rate_radps,
                      node.NumberOr("yaw_rate_radps", 0, -10, 10));
  TL_ASSIGN_OR_RETURN(const double for_s, node.Number("for_s", 0, kMaxTime_s));
  drive.duration = FromSeconds(for_s);
  return drive;
}

absl::StatusOr<Action> ReadTour(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(node.CheckKeys({"speed_mps", "repeats", "corners"}));
  TourAction tour;
  TL_ASSIGN_OR_RETURN(tour.options.speed_mps,
                      node.NumberOr("speed_mps", 0.5, 0.05, 5));
  TL_ASSIGN_OR_RETURN(tour.options.repeats, node.BooleanOr("repeats", false));
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> corners,
                      node.Items("corners"));
  for (const yaml::YamlNode& corner : corners) {
    TL_ASSIGN_OR_RETURN(const std::vector<double> at,
                        corner.AsNumbers(3, -kMaxLength_m, kMaxLength_m));
    tour.corners.push_back({at[0], at[1], at[2]});
  }
  return tour;
}

absl::StatusOr<Action> ReadFault(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(
      node.CheckKeys({"target", "kind", "for_s", "share", "seconds"}));
  Fault fault;
  TL_ASSIGN_OR_RETURN(const std::string target, node.Text("target"));
  TL_ASSIGN_OR_RETURN(const std::string kind, node.Text("kind"));
  const auto parsed_target = ParseFaultTarget(target);
  if (!parsed_target.ok()) return node.Error(parsed_target.status().message());
  const auto parsed_kind = ParseFaultKind(kind);
  if (!parsed_kind.ok()) return node.Error(parsed_kind.status().message());
  fault.target = *parsed_target;
  fault.kind = *parsed_kind;
  if (node.Has("for_s")) {
    TL_ASSIGN_OR_RETURN(const double for_s,
                        node.Number("for_s", 0, kMaxTime_s));
    fault.duration = FromSeconds(for_s);
  }
  const bool in_seconds =
      fault.kind == FaultKind::kStampOffset || fault.kind == FaultKind::kDelay;
  if (node.Has(in_seconds ? "share" : "seconds")) {
    return node.Error(in_seconds ? "this fault has 'seconds', not a 'share'"
                                 : "this fault has no 'seconds'");
  }
  if (in_seconds) {
    TL_ASSIGN_OR_RETURN(fault.amount, node.Number("seconds", -3600, 3600));
  } else {
    TL_ASSIGN_OR_RETURN(fault.amount, node.NumberOr("share", 1, 0, 1));
  }
  const absl::Status valid = fault.Validate();
  if (!valid.ok()) return node.Error(valid.message());
  return FaultAction{fault};
}

absl::StatusOr<Action> ReadAddObstacle(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(
      node.CheckKeys({"name", "body", "at", "yaw_deg", "height_m", "scale"}));
  AddObstacleAction add;
  TL_ASSIGN_OR_RETURN(add.body, node.Text("body"));
  TL_ASSIGN_OR_RETURN(add.name, node.TextOr("name", add.body));
  TL_ASSIGN_OR_RETURN(add.placement, ReadPlacement(node));
  if (node.Has("scale")) {
    TL_ASSIGN_OR_RETURN(const std::vector<double> scale,
                        node.Numbers("scale", 3, 0.01, 100));
    add.scale = {static_cast<float>(scale[0]), static_cast<float>(scale[1]),
                 static_cast<float>(scale[2])};
  }
  return add;
}

absl::StatusOr<Action> ReadMove(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(node.CheckKeys({"name", "at", "yaw_deg", "height_m"}));
  MoveBodyAction move;
  TL_ASSIGN_OR_RETURN(move.name, node.Text("name"));
  TL_ASSIGN_OR_RETURN(move.placement, ReadPlacement(node));
  return move;
}

absl::StatusOr<Action> ReadDoor(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(node.CheckKeys({"name", "angle_deg"}));
  DoorAction door;
  TL_ASSIGN_OR_RETURN(door.name, node.Text("name"));
  TL_ASSIGN_OR_RETURN(const double angle_deg,
                      node.Number("angle_deg", -360, 360));
  door.angle_rad = Radians(angle_deg);
  return door;
}

absl::StatusOr<Action> ReadKidnap(const yaml::YamlNode& node) {
  KidnapAction kidnap;
  TL_RETURN_IF_ERROR(ReadPlace(node, kidnap.place, kidnap.placement));
  return kidnap;
}

constexpr const char* kActions[] = {
    "drive", "tour",           "stop",         "kidnap",
    "fault", "reset_odometry", "add_obstacle", "remove_obstacle",
    "move",  "door",           "release"};

absl::StatusOr<Action> ReadWhat(absl::string_view key,
                                const yaml::YamlNode& action) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode node, action.Get(key));
  if (key == "drive") return ReadDrive(node);
  if (key == "tour") return ReadTour(node);
  if (key == "kidnap") return ReadKidnap(node);
  if (key == "fault") return ReadFault(node);
  if (key == "add_obstacle") return ReadAddObstacle(node);
  if (key == "move") return ReadMove(node);
  if (key == "door") return ReadDoor(node);
  if (key == "stop" || key == "reset_odometry") {
    TL_ASSIGN_OR_RETURN(const bool yes, action.BooleanOr(key, true));
    if (!yes) return node.Error("only 'true' has a meaning here");
    if (key == "stop") return StopAction{};
    return ResetOdometryAction{};
  }
  TL_ASSIGN_OR_RETURN(const std::string name, node.AsText());
  if (key == "remove_obstacle") return RemoveObstacleAction{name};
  return ReleaseAction{name};
}

absl::StatusOr<ScenarioAction> ReadAction(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(node.CheckKeys(
      {"at_s", "drive", "tour", "stop", "kidnap", "fault", "reset_odometry",
       "add_obstacle", "remove_obstacle", "move", "door", "release"}));
  TL_ASSIGN_OR_RETURN(const double at_s, node.Number("at_s", 0, kMaxTime_s));
  const auto stands_there = [&](const char* key) { return node.Has(key); };
  if (std::count_if(std::begin(kActions), std::end(kActions), stands_there) !=
      1) {
    return node.Error("one thing to do is needed, and one only");
  }
  const char* key =
      *std::find_if(std::begin(kActions), std::end(kActions), stands_there);
  ScenarioAction action = {.at = FromSeconds(at_s), .line = node.line()};
  TL_ASSIGN_OR_RETURN(action.what, ReadWhat(key, node));
  return action;
}

absl::Status ReadErrors(const yaml::YamlNode& node,
                        WheelOdometryErrors& errors) {
  const std::pair<const char*, double*> fields[] = {
      {"wheel_radius", &errors.wheel_radius},
      {"track", &errors.track},
      {"distance_m_per_sqrt_m", &errors.distance_m_per_sqrt_m},
      {"turn_m_per_sqrt_rad", &errors.turn_m_per_sqrt_rad},
      {"slope_slip", &errors.slope_slip},
      {"slip_bursts_hz", &errors.slip_bursts_hz},
      {"counts_per_m", &errors.counts_per_m},
      {"tilt_noise_rad", &errors.tilt_noise_rad},
      {"tilt_bias_rad", &errors.tilt_bias_rad},
      {"yaw_rate_scale", &errors.yaw_rate_scale},
      {"yaw_rate_noise_radps", &errors.yaw_rate_noise_radps}};
  TL_RETURN_IF_ERROR(node.CheckKeys(
      {"wheel_radius", "track", "distance_m_per_sqrt_m", "turn_m_per_sqrt_rad",
       "slope_slip", "slip_bursts_hz", "counts_per_m", "tilt_noise_rad",
       "tilt_bias_rad", "yaw_rate_scale", "yaw_rate_noise_radps"}));
  for (const auto& [name, field] : fields) {
    TL_ASSIGN_OR_RETURN(*field, node.NumberOr(name, *field, 0, 1e9));
  }
  const absl::Status valid = errors.Validate();
  return valid.ok() ? valid : node.Error(valid.message());
}

absl::Status ReadRobot(const yaml::YamlNode& node, core::RobotModel& robot) {
  const std::pair<const char*, double*> fields[] = {
      {"front_m", &robot.front_m},
      {"rear_m", &robot.rear_m},
      {"half_width_m", &robot.half_width_m},
      {"height_m", &robot.height_m},
      {"ground_clearance_m", &robot.ground_clearance_m},
      {"wheel_track_m", &robot.wheel_track_m},
      {"caster_m", &robot.caster_m},
      {"max_step_m", &robot.max_step_m},
      {"max_slope_rad", &robot.max_slope_rad},
      {"max_forward_mps", &robot.max_forward_mps},
      {"max_backward_mps", &robot.max_backward_mps},
      {"max_yaw_rate_radps", &robot.max_yaw_rate_radps},
      {"max_acceleration_mps2", &robot.max_acceleration_mps2},
      {"max_deceleration_mps2", &robot.max_deceleration_mps2},
      {"max_yaw_acceleration_radps2", &robot.max_yaw_acceleration_radps2}};
  TL_RETURN_IF_ERROR(node.CheckKeys(
      {"front_m", "rear_m", "half_width_m", "height_m", "ground_clearance_m",
       "wheel_track_m", "caster_m", "max_step_m", "max_slope_rad",
       "max_forward_mps", "max_backward_mps", "max_yaw_rate_radps",
       "max_acceleration_mps2", "max_deceleration_mps2",
       "max_yaw_acceleration_radps2"}));
  for (const auto& [name, field] : fields) {
    TL_ASSIGN_OR_RETURN(*field, node.NumberOr(name, *field, 0, 100));
  }
  const absl::Status valid = robot.Validate();
  return valid.ok() ? valid : node.Error(valid.message());
}

absl::Status ReadSensors(const yaml::YamlNode& node, SensorOptions& sensors) {
  TL_RETURN_IF_ERROR(
      node.CheckKeys({"laser", "camera_hz", "odometry_hz", "laser_latency_s",
                      "odometry_latency_s", "camera_latency_s"}));
  TL_ASSIGN_OR_RETURN(sensors.has_laser, node.BooleanOr("laser", true));
  const std::pair<const char*, double*> fields[] = {
      {"camera_hz", &sensors.camera_hz},
      {"odometry_hz", &sensors.odometry_hz},
      {"laser_latency_s", &sensors.laser_latency_s},
      {"odometry_latency_s", &sensors.odometry_latency_s},
      {"camera_latency_s", &sensors.camera_latency_s}};
  for (const auto& [name, field] : fields) {
    TL_ASSIGN_OR_RETURN(*field, node.NumberOr(name, *field, 0, 200));
  }
  const absl::Status valid = sensors.Validate();
  return valid.ok() ? valid : node.Error(valid.message());
}

absl::Status ReadRobotAndSensors(const yaml::YamlNode& root,
                                 SimulatorOptions& options) {
  if (root.Has("robot")) {
    TL_ASSIGN_OR_RETURN(const yaml::YamlNode node, root.Get("robot"));
    TL_RETURN_IF_ERROR(ReadRobot(node, options.robot));
  }
  if (root.Has("sensors")) {
    TL_ASSIGN_OR_RETURN(const yaml::YamlNode node, root.Get("sensors"));
    TL_RETURN_IF_ERROR(ReadSensors(node, options.sensors));
  }
  if (!root.Has("errors")) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode node, root.Get("errors"));
  if (!node.IsMap()) {
    TL_ASSIGN_OR_RETURN(const bool has_errors, root.Boolean("errors"));
    if (!has_errors) options.errors = WheelOdometryErrors::None();
    return absl::OkStatus();
  }
  return ReadErrors(node, options.errors);
}

absl::Status ReadRearranged(const yaml::YamlNode& node,
                            worlds::Rearrangement& rearranged) {
  TL_RETURN_IF_ERROR(node.CheckKeys({"seed", "share"}));
  TL_ASSIGN_OR_RETURN(const int64_t seed,
                      node.Integer("seed", 0, int64_t{1} << 53));
  rearranged.seed = static_cast<uint64_t>(seed);
  TL_ASSIGN_OR_RETURN(rearranged.share, node.Number("share", 0, 1));
  return absl::OkStatus();
}

absl::StatusOr<Scenario> ReadRoot(const yaml::YamlNode& root) {
  TL_RETURN_IF_ERROR(root.CheckKeys(
      {"world", "seed", "people", "after_moves", "rearranged", "lighting",
       "duration_s", "start", "robot", "sensors", "errors", "actions"}));
  Scenario scenario;
  TL_ASSIGN_OR_RETURN(scenario.world, root.TextOr("world", "cafe"));
  TL_ASSIGN_OR_RETURN(const int64_t seed,
                      root.IntegerOr("seed", 0, 0, int64_t{1} << 62));
  scenario.options.seed = static_cast<uint64_t>(seed);
  TL_ASSIGN_OR_RETURN(scenario.world_options.with_people,
                      root.BooleanOr("people", true));
  TL_ASSIGN_OR_RETURN(scenario.world_options.after_moves,
                      root.BooleanOr("after_moves", false));
  if (root.Has("rearranged")) {
    TL_ASSIGN_OR_RETURN(const yaml::YamlNode node, root.Get("rearranged"));
    TL_RETURN_IF_ERROR(ReadRearranged(node, scenario.world_options.rearranged));
  }
  if (root.Has("lighting")) {
    TL_ASSIGN_OR_RETURN(const yaml::YamlNode node, root.Get("lighting"));
    TL_ASSIGN_OR_RETURN(scenario.world_options.lighting,
                        building::ReadLighting(node));
  }
  TL_ASSIGN_OR_RETURN(const double duration_s,
                      root.NumberOr("duration_s", 0, 0, kMaxTime_s));
  scenario.duration = FromSeconds(duration_s);
  if (root.Has("start")) {
    TL_ASSIGN_OR_RETURN(const yaml::YamlNode start, root.Get("start"));
    TL_RETURN_IF_ERROR(ReadPlace(start, scenario.start_place, scenario.start));
  }
  TL_RETURN_IF_ERROR(ReadRobotAndSensors(root, scenario.options));
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> actions,
                      root.Items("actions"));
  for (const yaml::YamlNode& node : actions) {
    TL_ASSIGN_OR_RETURN(ScenarioAction action, ReadAction(node));
    scenario.actions.push_back(std::move(action));
  }
  std::ranges::stable_sort(scenario.actions, {}, &ScenarioAction::at);
  return scenario;
}

}  // namespace

absl::StatusOr<Scenario> ParseScenario(absl::string_view text,
                                       absl::string_view name) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode root,
                      yaml::YamlNode::Parse(text, name));
  return ReadRoot(root);
}

absl::StatusOr<Scenario> ReadScenario(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode root, yaml::YamlNode::Read(path));
  return ReadRoot(root);
}

}  // namespace treeline::simulator
