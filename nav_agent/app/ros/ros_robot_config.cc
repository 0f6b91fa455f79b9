#include "nav_agent/app/ros/ros_robot_config.h"

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/config/config_table.h"
#include "nav_agent/app/bridge/bridge_config.h"

namespace treeline::ros_app {
namespace {

using bridge_app::BridgeConfig;

// The file, flat; what it shares with the relocalizer is read as there.
struct RobotFile : core::MeasuredOdometryNoise {
  int domain_id = -1;
  std::string interface;
  std::string rmw;
  std::string name_space;
  std::string node_name = "treeline";
  std::vector<std::string> remap;
  bool use_sim_time = false;
  std::string scan = RosRobotConfig().scan;
  std::string rear_scan;
  std::string odom = RosRobotConfig().odom;
  std::string battery;
  std::string image;
  std::string camera_info;
  std::string depth;
  bool reliable_pictures = false;
  bool rectified = false;
  double picture_hz = RosRobotConfig().picture_hz;
  std::string cmd_vel = RosRobotConfig().cmd_vel;
  bool stamped_cmd_vel = false;
  std::string map = RosRobotConfig().map;
  std::string plan = RosRobotConfig().plan;
  std::string pose = RosRobotConfig().pose;
  std::string goal = RosRobotConfig().goal;
  std::string navigate_to_pose = RosRobotConfig().navigate_to_pose;
  std::string initial_pose = RosRobotConfig().initial_pose;
  bool publish_tf = true;
  double tf_tolerance_s = RosRobotConfig().tf_tolerance_s;
  std::string map_frame = RosRobotConfig().map_frame;
  std::string base_frame = RosRobotConfig().base_frame;
  std::vector<std::string> base_from_laser;
  std::vector<std::string> base_from_rear_laser;
  std::vector<std::string> base_from_camera;
  double front_m = core::RobotModel().front_m;
  double rear_m = core::RobotModel().rear_m;
  double half_width_m = core::RobotModel().half_width_m;
  double height_m = core::RobotModel().height_m;
  double wheel_track_m = core::RobotModel().wheel_track_m;
  double wheel_radius_m = core::RobotModel().wheel_radius_m;
  double max_forward_mps = core::RobotModel().max_forward_mps;
  double max_backward_mps = core::RobotModel().max_backward_mps;
  double max_yaw_rate_radps = core::RobotModel().max_yaw_rate_radps;
  double max_acceleration_mps2 = core::RobotModel().max_acceleration_mps2;
  double max_deceleration_mps2 = core::RobotModel().max_deceleration_mps2;
  double max_yaw_acceleration_radps2 =
      core::RobotModel().max_yaw_acceleration_radps2;
  double left_wheel_scale = 1;
  double right_wheel_scale = 1;
  double turn_scale = 1;
  double laser_delay_s = 0;
  double camera_delay_s = 0;
  std::string charging_contacts;
};

using Table = config::ConfigTable<RobotFile>;

void AddNetwork(Table& table) {
  table.Add(&RobotFile::domain_id,
            {.name = "domain_id", .help = "DDS domain", .min = -1, .max = 232});
  table.Add(&RobotFile::interface,
            {.name = "interface", .help = "Network interface to use alone"});
  table.Add(&RobotFile::rmw,
            {.name = "rmw", .help = "The robot's RMW_IMPLEMENTATION"});
  table.Add(&RobotFile::name_space,
            {.name = "namespace", .help = "Of all relative topics"});
  table.Add(&RobotFile::node_name,
            {.name = "node_name", .help = "Of topics that begin with ~/"});
  table.Add(&RobotFile::remap,
            {.name = "remap", .help = "FROM:=TO, as ROS 2 has it"});
  table.Add(&RobotFile::use_sim_time,
            {.name = "use_sim_time", .help = "Time is what /clock says"});
}

void AddTopics(Table& table) {
  const auto add = [&table](std::string RobotFile::*field, const char* name,
                            const char* help) {
    table.Add(field, {.name = name, .help = help});
  };
  add(&RobotFile::scan, "scan", "LaserScan of the laser ahead");
  add(&RobotFile::rear_scan, "rear_scan", "LaserScan of one that looks back");
  add(&RobotFile::odom, "odom", "Odometry");
  add(&RobotFile::battery, "battery", "BatteryState");
  add(&RobotFile::image, "image", "Image, or CompressedImage");
  add(&RobotFile::camera_info, "camera_info", "CameraInfo");
  add(&RobotFile::depth, "depth", "Depth registered to the pictures");
  add(&RobotFile::cmd_vel, "cmd_vel", "Twist");
  add(&RobotFile::map, "map", "OccupancyGrid, out");
  add(&RobotFile::plan, "plan", "Path, out");
  add(&RobotFile::pose, "pose", "PoseWithCovarianceStamped, out");
  add(&RobotFile::goal, "goal", "PoseStamped, in");
  add(&RobotFile::navigate_to_pose, "navigate_to_pose",
      "The action NavigateToPose");
  add(&RobotFile::initial_pose, "initial_pose",
      "PoseWithCovarianceStamped, in");
  add(&RobotFile::map_frame, "map_frame", "Of the map");
  add(&RobotFile::base_frame, "base_frame", "Of the robot, on the ground");
  table.Add(&RobotFile::reliable_pictures,
            {.name = "reliable_pictures", .help = "Ask for lost parts again"});
  table.Add(&RobotFile::rectified,
            {.name = "rectified", .help = "Pictures are rectified"});
  table.Add(&RobotFile::picture_hz, {.name = "picture_hz",
                                     .help = "Pictures that are decoded",
                                     .min = 0.1,
                                     .max = 60});
  table.Add(&RobotFile::stamped_cmd_vel,
            {.name = "stamped_cmd_vel", .help = "TwistStamped instead"});
  table.Add(&RobotFile::publish_tf,
            {.name = "publish_tf", .help = "map_frame to odom on /tf"});
  table.Add(&RobotFile::tf_tolerance_s, {.name = "tf_tolerance_s",
                                         .help = "How far ahead it is stamped",
                                         .min = 0,
                                         .max = 5});
  for (const auto& [field, name] :
       {std::pair{&RobotFile::base_from_laser, "base_from_laser"},
        std::pair{&RobotFile::base_from_rear_laser, "base_from_rear_laser"},
        std::pair{&RobotFile::base_from_camera, "base_from_camera"}}) {
    table.Add(field, {.name = name, .help = "X,Y,Z,YAW or with a quaternion"});
  }
}

void AddMeasures(Table& table) {
  const auto add = [&table](double RobotFile::*field, const char* name,
                            const char* help, double min, double max) {
    table.Add(field, {.name = name, .help = help, .min = min, .max = max});
  };
  add(&RobotFile::front_m, "front_m", "Axle to front edge", 0.01, 5);
  add(&RobotFile::rear_m, "rear_m", "Axle to rear edge", 0.01, 5);
  add(&RobotFile::half_width_m, "half_width_m", "Middle to side", 0.01, 5);
  add(&RobotFile::height_m, "height_m", "Its highest point", 0.05, 5);
  add(&RobotFile::wheel_track_m, "wheel_track_m", "Wheel to wheel", 0.05, 5);
  add(&RobotFile::wheel_radius_m, "wheel_radius_m", "Of a wheel", 0.01, 2);
  add(&RobotFile::max_forward_mps, "max_forward_mps", "Its speed", 0.05, 3);
  add(&RobotFile::max_backward_mps, "max_backward_mps", "... back", 0.02, 3);
  add(&RobotFile::max_yaw_rate_radps, "max_yaw_rate_radps", "... turning", 0.1,
      10);
  add(&RobotFile::max_acceleration_mps2, "max_acceleration_mps2",
      "How fast it gets faster", 0.05, 10);
  add(&RobotFile::max_deceleration_mps2, "max_deceleration_mps2",
      "... and slower", 0.05, 10);
  add(&RobotFile::max_yaw_acceleration_radps2, "max_yaw_acceleration_radps2",
      "... and turns faster", 0.1, 50);
}

void AddCorrection(Table& table) {
  const auto add = [&table](double RobotFile::*field, const char* name,
                            const char* help, double min, double max) {
    table.Add(field, {.name = name, .help = help, .min = min, .max = max});
  };
  add(&RobotFile::left_wheel_scale, "left_wheel_scale",
      "What the left wheel's way is multiplied by", 0.5, 2);
  add(&RobotFile::right_wheel_scale, "right_wheel_scale",
      "... and the right one's", 0.5, 2);
  add(&RobotFile::turn_scale, "turn_scale", "... and turns after that", 0.5, 2);
  add(&RobotFile::laser_delay_s, "laser_delay_s",
      "Scans are stamped later than odometry by this", -0.5, 0.5);
  add(&RobotFile::camera_delay_s, "camera_delay_s",
      "... and pictures of the camera", -0.5, 0.5);
  table.Add(&RobotFile::charging_contacts,
            {.name = "charging_contacts",
             .help = "At which end of the robot they are; '': as docks say",
             .choices = {"", "front", "rear"}});
  for (const auto& [name, value] : core::kNoiseKeys) {
    add(value, name, "How noisy odometry was measured to be", 0,
        core::kMostNoise);
  }
}

const Table& RobotTable() {
  // Immutable; made by the first who asks.
  static const auto* const table = [] {
    auto* made = new Table;
    AddNetwork(*made);
    AddTopics(*made);
    AddMeasures(*made);
    AddCorrection(*made);
    return made;
  }();
  return *table;
}

core::RobotModel ModelOf(const RobotFile& file) {
  core::RobotModel robot;
  robot.front_m = file.front_m;
  robot.rear_m = file.rear_m;
  robot.half_width_m = file.half_width_m;
  robot.height_m = file.height_m;
  robot.wheel_track_m = file.wheel_track_m;
  robot.wheel_radius_m = file.wheel_radius_m;
  robot.max_forward_mps = file.max_forward_mps;
  robot.max_backward_mps = file.max_backward_mps;
  robot.max_yaw_rate_radps = file.max_yaw_rate_radps;
  robot.max_acceleration_mps2 = file.max_acceleration_mps2;
  robot.max_deceleration_mps2 = file.max_deceleration_mps2;
  robot.max_yaw_acceleration_radps2 = file.max_yaw_acceleration_radps2;
  // Casters are within its body.
  robot.caster_m = std::min({robot.caster_m, robot.front_m, robot.rear_m});
  return robot;
}

absl::Status TakeTransform(const std::vector<std::string>& numbers,
                           const char* name,
                           std::optional<geometry::Rigid3>& transform) {
  if (numbers.empty()) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(transform, bridge_app::ParseTransform(numbers, name));
  return absl::OkStatus();
}

// environment: of RMW_IMPLEMENTATION; null: none.
absl::StatusOr<Rmw> RmwOf(const RobotFile& file, const char* environment) {
  std::string name = file.rmw;
  if (name.empty() && environment != nullptr) name = environment;
  if (name.empty() || name == "rmw_fastrtps_cpp" ||
      name == "rmw_fastrtps_dynamic_cpp") {
    return Rmw::kFastDds;
  }
  if (name == "rmw_cyclonedds_cpp") return Rmw::kCyclone;
  return absl::InvalidArgumentError(absl::StrCat(
      "rmw is ", name, file.rmw.empty() ? ", by RMW_IMPLEMENTATION" : "",
      "; rmw_fastrtps_cpp and rmw_cyclonedds_cpp are spoken"));
}

// What the relocalizer's settings say likewise.
absl::Status TakeNetwork(const RobotFile& file, RosRobotConfig& config) {
  BridgeConfig bridge;
  bridge.domain_id = file.domain_id;
  bridge.interface = file.interface;
  bridge.name_space = file.name_space;
  bridge.node_name = file.node_name;
  bridge.remap = file.remap;
  bridge.image = file.image;
  bridge.camera_info = file.camera_info;
  TL_ASSIGN_OR_RETURN(config.domain,
                      bridge.Domain(std::getenv("ROS_DOMAIN_ID")));
  TL_ASSIGN_OR_RETURN(config.node, bridge.Node());
  TL_ASSIGN_OR_RETURN(config.rmw,
                      RmwOf(file, std::getenv("RMW_IMPLEMENTATION")));
  config.image = file.image;
  if (!file.image.empty()) config.camera_info = bridge.CameraInfoTopic();
  return absl::OkStatus();
}

absl::StatusOr<RosRobotConfig> ConfigOf(const RobotFile& file) {
  RosRobotConfig config;
  TL_RETURN_IF_ERROR(TakeNetwork(file, config));
  config.use_sim_time = file.use_sim_time;
  config.scan = file.scan;
  config.rear_scan = file.rear_scan;
  config.odom = file.odom;
  config.battery = file.battery;
  config.depth = file.depth;
  config.reliable_pictures = file.reliable_pictures;
  config.is_rectified = file.rectified;
  config.picture_hz = file.picture_hz;
  config.cmd_vel = file.cmd_vel;
  config.is_cmd_vel_stamped = file.stamped_cmd_vel;
  config.map = file.map;
  config.plan = file.plan;
  config.pose = file.pose;
  config.goal = file.goal;
  config.navigate_to_pose = file.navigate_to_pose;
  config.initial_pose = file.initial_pose;
  config.publishes_tf = file.publish_tf;
  config.tf_tolerance_s = file.tf_tolerance_s;
  config.map_frame = file.map_frame;
  config.base_frame = file.base_frame;
  TL_RETURN_IF_ERROR(TakeTransform(file.base_from_laser, "base_from_laser",
                                   config.base_from_laser));
  TL_RETURN_IF_ERROR(TakeTransform(file.base_from_rear_laser,
                                   "base_from_rear_laser",
                                   config.base_from_rear_laser));
  TL_RETURN_IF_ERROR(TakeTransform(file.base_from_camera, "base_from_camera",
                                   config.base_from_camera));
  config.robot = ModelOf(file);
  config.correction = {.left_scale = file.left_wheel_scale,
                       .right_scale = file.right_wheel_scale,
                       .turn_scale = file.turn_scale,
                       .laser_delay_s = file.laser_delay_s,
                       .camera_delay_s = file.camera_delay_s};
  TL_ASSIGN_OR_RETURN(config.noise, core::NoiseOfFile(file));
  TL_ASSIGN_OR_RETURN(config.contacts,
                      core::ContactEndOf(file.charging_contacts));
  TL_RETURN_IF_ERROR(config.Validate());
  return config;
}

}  // namespace

absl::Status RosRobotConfig::Validate() const {
  if (scan.empty() || odom.empty() || cmd_vel.empty()) {
    return absl::InvalidArgumentError(
        "the topics scan, odom and cmd_vel are needed");
  }
  if (scan == rear_scan) {
    return absl::InvalidArgumentError(absl::StrCat(
        "scan and rear_scan are both ", scan, "; they are two lasers"));
  }
  if (!depth.empty() && image.empty()) {
    return absl::InvalidArgumentError(
        "depth is registered to pictures: give image, too");
  }
  if (map_frame.empty() || base_frame.empty() || map_frame == base_frame) {
    return absl::InvalidArgumentError(
        "map_frame and base_frame are two frames, and both are needed");
  }
  return robot.Validate();
}

absl::StatusOr<RosRobotConfig> ReadRosRobotConfig(const std::string& path) {
  const Table& table = RobotTable();
  TL_ASSIGN_OR_RETURN(const config::EffectiveConfig effective,
                      config::ResolveConfig(table.settings(), {.file = path}));
  absl::StatusOr<RosRobotConfig> config = ConfigOf(table.Make(effective));
  if (!config.ok()) return base::Annotate(config.status(), path);
  return config;
}

}  // namespace treeline::ros_app
