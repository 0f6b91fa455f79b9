#include "nav_agent/core/robot_file.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/check_range.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "common/yaml/yaml_node.h"

namespace treeline::core {
namespace {

constexpr size_t kMaxFileBytes = 65536;
constexpr size_t kMaxCorners = 64;
// Of SensorCorrection.
constexpr double kMinScale = 0.5;
constexpr double kMaxScale = 2;
constexpr double kMaxDelay_s = 0.5;

RangeSensorInfo LaserOf(int beams, double field_of_view_rad, double min_m,
                        double max_m, double rate_hz) {
  RangeSensorInfo laser;
  laser.angle_min_rad = -field_of_view_rad / 2;
  laser.angle_increment_rad = field_of_view_rad / (beams - 1);
  laser.beams = beams;
  laser.range_min_m = min_m;
  laser.range_max_m = max_m;
  laser.scan_interval_s = 1 / rate_hz;
  // The mirror turns once a scan, evenly.
  laser.beam_interval_s = laser.scan_interval_s * laser.angle_increment_rad /
                          (2 * std::numbers::pi);
  return laser;
}

constexpr double kTurn270_rad = 1.5 * std::numbers::pi;

RobotDescription Rmp100() {
  return {.name = "rmp100",
          .model = {},
          .lasers = {.front = LaserOf(1081, kTurn270_rad, 0.1, 30, 40),
                     .rear = LaserOf(541, kTurn270_rad, 0.06, 10, 40)}};
}

// Clearpath's data sheet; lengths and speeds as in the challenge's simulation
// (jackal_description, jackal_control). The controller there allows 20 m/s^2,
// which no such robot reaches on its tyres; here it is what they hold.
RobotDescription Jackal() {
  RobotDescription jackal = {
      .name = "jackal",
      .model = {},
      .lasers = {.front = LaserOf(720, kTurn270_rad, 0.1, 30, 40)}};
  RobotModel& model = jackal.model;
  model.front_m = 0.254;
  model.rear_m = 0.254;
  model.half_width_m = 0.215;
  model.height_m = 0.30;
  model.ground_clearance_m = 0.06;
  model.wheel_track_m = 0.37559;
  model.wheel_radius_m = 0.098;
  model.caster_m = 0.131;
  model.max_forward_mps = 2.0;
  model.max_backward_mps = 1.0;
  model.max_yaw_rate_radps = 3.0;
  model.max_acceleration_mps2 = 3.0;
  model.max_deceleration_mps2 = 4.0;
  model.max_yaw_acceleration_radps2 = 12.0;
  model.base_from_laser.translation = {0.055, 0, 0.21};
  model.base_from_rear_laser.translation = {-0.055, 0, 0.21};
  model.base_from_camera = RobotModel::UprightCamera({0.15, 0, 0.25}, 0);
  return jackal;
}

// Of turtlebot3_description (burger) and its data sheet; accelerations as its
// firmware ramps. The LDS-01 sees all around, five times a second.
RobotDescription TurtleBot3() {
  RobotDescription robot = {
      .name = "turtlebot3",
      .model = {},
      .lasers = {.front = LaserOf(360, 2 * std::numbers::pi * 359 / 360, 0.12,
                                  3.5, 5)}};
  RobotModel& model = robot.model;
  model.front_m = 0.038;
  model.rear_m = 0.102;
  model.half_width_m = 0.09;
  model.height_m = 0.192;
  model.ground_clearance_m = 0.01;
  model.wheel_track_m = 0.160;
  model.wheel_radius_m = 0.033;
  model.caster_m = 0.035;
  model.max_step_m = 0.005;
  model.max_slope_rad = 0.15;
  model.max_forward_mps = 0.22;
  model.max_backward_mps = 0.22;
  model.max_yaw_rate_radps = 2.84;
  model.max_acceleration_mps2 = 1.0;
  model.max_deceleration_mps2 = 1.0;
  model.max_yaw_acceleration_radps2 = 6.0;
  model.base_from_laser.translation = {-0.032, 0, 0.182};
  model.base_from_rear_laser.translation = {-0.032, 0, 0.182};
  model.base_from_camera = RobotModel::UprightCamera({0.03, 0, 0.10}, 0);
  return robot;
}

const RobotDescription* FindRobot(absl::string_view name) {
  // Immutable; made by the first who asks.
  static const auto* const robots =
      new std::vector{Rmp100(), Jackal(), TurtleBot3()};
  for (const RobotDescription& robot : *robots) {
    if (robot.name == name) return &robot;
  }
  return nullptr;
}

absl::Status UnknownRobot(absl::string_view name) {
  return absl::InvalidArgumentError(absl::StrCat(
      "there is no robot '", name, "'; there are ",
      absl::StrJoin(RobotNames(), ", "), " and files (NAME.yaml)"));
}

// [x, y] corners: what they fill, as the rectangle around it.
absl::Status ReadFootprint(const yaml::YamlNode& file, RobotModel& model) {
  if (!file.Has("footprint")) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> corners,
                      file.Items("footprint"));
  if (corners.size() < 3 || corners.size() > kMaxCorners) {
    return file.Error("a footprint has 3 to 64 corners, [x, y] in m");
  }
  double front_m = 0;
  double rear_m = 0;
  double side_m = 0;
  for (const yaml::YamlNode& corner : corners) {
    TL_ASSIGN_OR_RETURN(const std::vector<double> at,
                        corner.AsNumbers(2, -5, 5));
    front_m = std::max(front_m, at[0]);
    rear_m = std::max(rear_m, -at[0]);
    side_m = std::max(side_m, std::abs(at[1]));
  }
  model.front_m = front_m;
  model.rear_m = rear_m;
  model.half_width_m = side_m;
  return absl::OkStatus();
}

absl::Status ReadMeasures(const yaml::YamlNode& file, RobotModel& model) {
  const auto read = [&file](const char* key, double& value,
                            double max) -> absl::Status {
    TL_ASSIGN_OR_RETURN(value, file.NumberOr(key, value, 0.001, max));
    return absl::OkStatus();
  };
  TL_RETURN_IF_ERROR(read("front_m", model.front_m, 5));
  TL_RETURN_IF_ERROR(read("rear_m", model.rear_m, 5));
  TL_RETURN_IF_ERROR(read("half_width_m", model.half_width_m, 5));
  TL_RETURN_IF_ERROR(read("height_m", model.height_m, 5));
  TL_RETURN_IF_ERROR(read("ground_clearance_m", model.ground_clearance_m, 2));
  TL_RETURN_IF_ERROR(read("wheel_track_m", model.wheel_track_m, 5));
  TL_RETURN_IF_ERROR(read("wheel_radius_m", model.wheel_radius_m, 2));
  TL_RETURN_IF_ERROR(read("caster_m", model.caster_m, 5));
  TL_RETURN_IF_ERROR(read("max_step_m", model.max_step_m, 1));
  TL_RETURN_IF_ERROR(read("max_slope_rad", model.max_slope_rad, 1));
  TL_RETURN_IF_ERROR(read("max_forward_mps", model.max_forward_mps, 10));
  TL_RETURN_IF_ERROR(read("max_backward_mps", model.max_backward_mps, 10));
  TL_RETURN_IF_ERROR(read("max_yaw_rate_radps", model.max_yaw_rate_radps, 20));
  TL_RETURN_IF_ERROR(
      read("max_acceleration_mps2", model.max_acceleration_mps2, 50));
  TL_RETURN_IF_ERROR(
      read("max_deceleration_mps2", model.max_deceleration_mps2, 50));
  return read("max_yaw_acceleration_radps2", model.max_yaw_acceleration_radps2,
              100);
}

// A laser of the file: where it is, and how it scans.
absl::Status ReadLaser(const yaml::YamlNode& node, geometry::Rigid3& mount,
                       RangeSensorInfo& laser) {
  TL_RETURN_IF_ERROR(
      node.CheckKeys({"at", "yaw_rad", "beams", "field_of_view_rad",
                      "range_min_m", "range_max_m", "rate_hz"}));
  if (node.Has("at")) {
    TL_ASSIGN_OR_RETURN(const std::vector<double> at,
                        node.Numbers("at", 3, -5, 5));
    mount.translation = {at[0], at[1], at[2]};
  }
  TL_ASSIGN_OR_RETURN(
      const double yaw_rad,
      node.NumberOr("yaw_rad", geometry::PlanarPose(mount).yaw_rad, -7, 7));
  mount.rotation = geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad});
  const double view_rad = laser.angle_increment_rad * (laser.beams - 1);
  TL_ASSIGN_OR_RETURN(const int64_t beams,
                      node.IntegerOr("beams", laser.beams, 2, 100000));
  TL_ASSIGN_OR_RETURN(
      const double wide_rad,
      node.NumberOr("field_of_view_rad", view_rad, 0.01, 2 * std::numbers::pi));
  TL_ASSIGN_OR_RETURN(const double min_m,
                      node.NumberOr("range_min_m", laser.range_min_m, 0, 10));
  TL_ASSIGN_OR_RETURN(
      const double max_m,
      node.NumberOr("range_max_m", laser.range_max_m, min_m + 0.1, 500));
  TL_ASSIGN_OR_RETURN(
      const double rate_hz,
      node.NumberOr("rate_hz", 1 / laser.scan_interval_s, 1, 200));
  laser = LaserOf(static_cast<int>(beams), wide_rad, min_m, max_m, rate_hz);
  return absl::OkStatus();
}

absl::Status ReadLasers(const yaml::YamlNode& file, RobotDescription& robot) {
  if (file.Has("laser")) {
    TL_ASSIGN_OR_RETURN(const yaml::YamlNode node, file.Get("laser"));
    TL_RETURN_IF_ERROR(
        ReadLaser(node, robot.model.base_from_laser, robot.lasers.front));
  }
  if (!file.Has("rear_laser")) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode node, file.Get("rear_laser"));
  if (!node.IsMap()) {
    TL_ASSIGN_OR_RETURN(const std::string none, node.AsText());
    if (none != "none") return node.Error("a rear laser is a map, or 'none'");
    robot.lasers.rear.reset();
    return absl::OkStatus();
  }
  if (!robot.lasers.rear.has_value()) robot.lasers.rear = robot.lasers.front;
  return ReadLaser(node, robot.model.base_from_rear_laser, *robot.lasers.rear);
}

// A camera that looks ahead, turned by its yaw, and then down.
absl::Status ReadCamera(const yaml::YamlNode& file, RobotModel& model) {
  if (!file.Has("camera")) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode node, file.Get("camera"));
  TL_RETURN_IF_ERROR(node.CheckKeys({"at", "yaw_rad", "down_rad"}));
  geometry::Vec3 place_m = model.base_from_camera.translation;
  if (node.Has("at")) {
    TL_ASSIGN_OR_RETURN(const std::vector<double> at,
                        node.Numbers("at", 3, -5, 5));
    place_m = {at[0], at[1], at[2]};
  }
  const geometry::Vec3 ahead =
      model.base_from_camera.rotation * geometry::Vec3{0, 0, 1};
  TL_ASSIGN_OR_RETURN(
      const double yaw_rad,
      node.NumberOr("yaw_rad", std::atan2(ahead.y, ahead.x), -7, 7));
  TL_ASSIGN_OR_RETURN(
      const double down_rad,
      node.NumberOr("down_rad", -std::asin(std::clamp(ahead.z, -1.0, 1.0)),
                    -1.5, 1.5));
  model.base_from_camera = {
      geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad}) *
          RobotModel::UprightCamera({}, down_rad).rotation,
      place_m};
  return absl::OkStatus();
}

absl::Status ReadCorrection(const yaml::YamlNode& node,
                            SensorCorrection& correction) {
  TL_ASSIGN_OR_RETURN(
      correction.left_scale,
      node.NumberOr("left_scale", correction.left_scale, kMinScale, kMaxScale));
  TL_ASSIGN_OR_RETURN(correction.right_scale,
                      node.NumberOr("right_scale", correction.right_scale,
                                    kMinScale, kMaxScale));
  TL_ASSIGN_OR_RETURN(
      correction.turn_scale,
      node.NumberOr("turn_scale", correction.turn_scale, kMinScale, kMaxScale));
  TL_ASSIGN_OR_RETURN(correction.laser_delay_s,
                      node.NumberOr("laser_delay_s", correction.laser_delay_s,
                                    -kMaxDelay_s, kMaxDelay_s));
  TL_ASSIGN_OR_RETURN(correction.camera_delay_s,
                      node.NumberOr("camera_delay_s", correction.camera_delay_s,
                                    -kMaxDelay_s, kMaxDelay_s));
  return absl::OkStatus();
}

absl::Status ReadNoise(const yaml::YamlNode& node,
                       std::optional<MeasuredOdometryNoise>& noise) {
  MeasuredOdometryNoise told;
  for (const auto& [name, value] : kNoiseKeys) {
    TL_ASSIGN_OR_RETURN(told.*value,
                        node.NumberOr(name, 0, kLeastNoise, kMostNoise));
  }
  const auto read = NoiseOfFile(told);
  if (!read.ok()) return node.Error(read.status().message());
  if (read->has_value()) noise = *read;
  return absl::OkStatus();
}

absl::Status ReadOdometry(const yaml::YamlNode& file, RobotDescription& robot) {
  if (!file.Has("odometry")) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode node, file.Get("odometry"));
  TL_RETURN_IF_ERROR(node.CheckKeys({"left_scale", "right_scale", "turn_scale",
                                     "laser_delay_s", "camera_delay_s",
                                     "turn_from_turn", "turn_from_drive",
                                     "drive_from_drive", "drive_from_turn"}));
  TL_RETURN_IF_ERROR(ReadCorrection(node, robot.correction));
  return ReadNoise(node, robot.noise);
}

}  // namespace

absl::Status SensorCorrection::Validate() const {
  TL_RETURN_IF_ERROR(
      base::CheckRange("left_scale", left_scale, kMinScale, kMaxScale));
  TL_RETURN_IF_ERROR(
      base::CheckRange("right_scale", right_scale, kMinScale, kMaxScale));
  TL_RETURN_IF_ERROR(
      base::CheckRange("turn_scale", turn_scale, kMinScale, kMaxScale));
  TL_RETURN_IF_ERROR(base::CheckRange("laser_delay_s", laser_delay_s,
                                      -kMaxDelay_s, kMaxDelay_s));
  return base::CheckRange("camera_delay_s", camera_delay_s, -kMaxDelay_s,
                          kMaxDelay_s);
}

absl::Status RobotDescription::Validate() const {
  TL_RETURN_IF_ERROR(model.Validate());
  TL_RETURN_IF_ERROR(correction.Validate());
  for (const geometry::Vec3& at : {model.base_from_laser.translation,
                                   model.base_from_rear_laser.translation}) {
    if (at.z <= 0 || at.z > model.height_m) {
      return absl::InvalidArgumentError(absl::StrCat(
          "robot: a laser ", at.z, " m above the ground, of a body ",
          model.height_m, " m high"));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<ContactEnd> ContactEndOf(absl::string_view name) {
  if (name.empty()) return ContactEnd::kUnsaid;
  if (name == "front") return ContactEnd::kFront;
  if (name == "rear") return ContactEnd::kRear;
  return absl::InvalidArgumentError(absl::StrCat(
      "charging_contacts is '", name, "'; it must be front or rear"));
}

std::vector<std::string> RobotNames() {
  return {"rmp100", "jackal", "turtlebot3"};
}

absl::StatusOr<RobotDescription> ParseRobot(absl::string_view text,
                                            absl::string_view name) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode file,
                      yaml::YamlNode::Parse(text, name));
  TL_RETURN_IF_ERROR(file.CheckKeys({"like",
                                     "footprint",
                                     "front_m",
                                     "rear_m",
                                     "half_width_m",
                                     "height_m",
                                     "ground_clearance_m",
                                     "wheel_track_m",
                                     "wheel_radius_m",
                                     "caster_m",
                                     "max_step_m",
                                     "max_slope_rad",
                                     "max_forward_mps",
                                     "max_backward_mps",
                                     "max_yaw_rate_radps",
                                     "max_acceleration_mps2",
                                     "max_deceleration_mps2",
                                     "max_yaw_acceleration_radps2",
                                     "laser",
                                     "rear_laser",
                                     "camera",
                                     "odometry",
                                     "charging_contacts"}));
  TL_ASSIGN_OR_RETURN(const std::string like, file.TextOr("like", "rmp100"));
  const RobotDescription* known = FindRobot(like);
  if (known == nullptr) return file.Error(UnknownRobot(like).message());
  RobotDescription robot = *known;
  robot.name = std::string(name);
  TL_RETURN_IF_ERROR(ReadFootprint(file, robot.model));
  TL_RETURN_IF_ERROR(ReadMeasures(file, robot.model));
  TL_RETURN_IF_ERROR(ReadLasers(file, robot));
  TL_RETURN_IF_ERROR(ReadCamera(file, robot.model));
  TL_RETURN_IF_ERROR(ReadOdometry(file, robot));
  TL_ASSIGN_OR_RETURN(const std::string contacts,
                      file.TextOr("charging_contacts", ""));
  const absl::StatusOr<ContactEnd> end = ContactEndOf(contacts);
  if (!end.ok()) return file.Error(end.status().message());
  robot.contacts = *end;
  const absl::Status valid = robot.Validate();
  if (!valid.ok()) return file.Error(valid.message());
  return robot;
}

absl::StatusOr<RobotDescription> ReadRobot(const std::string& name_or_path) {
  if (const RobotDescription* known = FindRobot(name_or_path)) return *known;
  if (!absl::EndsWith(name_or_path, ".yaml") &&
      !absl::StrContains(name_or_path, '/')) {
    return UnknownRobot(name_or_path);
  }
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(name_or_path, kMaxFileBytes));
  return ParseRobot(text, name_or_path);
}

}  // namespace treeline::core
