#include "nav_agent/app/bridge/bridge_config.h"

#include <cmath>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/check_heading.h"
#include "common/base/status_macros.h"

namespace treeline::bridge_app {
namespace {

using Table = config::ConfigTable<BridgeConfig>;

void AddNetwork(Table& table) {
  table.Add(&BridgeConfig::domain_id,
            {.name = "domain_id",
             .help = "DDS domain; -1: ROS_DOMAIN_ID of the environment, or 0",
             .min = -1,
             .max = 232});
  table.Add(&BridgeConfig::interface,
            {.name = "interface",
             .value_name = "NAME",
             .help = "Network interface to use alone, without multicast if "
                     "'lo'; '': what CYCLONEDDS_URI or Cyclone DDS chooses"});
  table.Add(&BridgeConfig::name_space,
            {.name = "namespace",
             .value_name = "NAME",
             .help = "Namespace of the node, of all relative topics"});
  table.Add(&BridgeConfig::node_name,
            {.name = "node_name",
             .value_name = "NAME",
             .help = "Name of the node, of topics that begin with ~/"});
  table.Add(&BridgeConfig::remap,
            {.name = "remap",
             .value_name = "FROM:=TO",
             .help = "Remapping of a topic, as ROS 2 has it; several times, or "
                     "separated by commas"});
  table.Add(&BridgeConfig::use_sim_time,
            {.name = "use_sim_time",
             .help = "Time is what /clock says, as in a simulation"});
}

void AddTopics(Table& table) {
  const auto add = [&table](std::string BridgeConfig::*field, const char* name,
                            const char* help) {
    table.Add(field, {.name = name, .value_name = "TOPIC", .help = help});
  };
  add(&BridgeConfig::image, "image",
      "Pictures; what ends with /compressed is sensor_msgs/CompressedImage, "
      "else sensor_msgs/Image");
  add(&BridgeConfig::camera_info, "camera_info",
      "Their sensor_msgs/CameraInfo; '': camera_info beside the pictures");
  add(&BridgeConfig::depth, "depth",
      "Depth registered to the pictures; '': none. What ends with "
      "/compressedDepth is compressed");
  add(&BridgeConfig::odom, "odom", "nav_msgs/Odometry");
  add(&BridgeConfig::scan, "scan",
      "sensor_msgs/LaserScan, for the gate and the verdict \"lost\"; '': none");
  add(&BridgeConfig::map, "map",
      "nav_msgs/OccupancyGrid, for the same; '': none");
  add(&BridgeConfig::initial_pose, "initial_pose",
      "Where places are published as geometry_msgs/PoseWithCovarianceStamped");
  table.Add(&BridgeConfig::reliable_pictures,
            {.name = "reliable_pictures",
             .help = "Ask for lost parts of pictures again; their publisher "
                     "must be reliable, too"});
}

void AddFrames(Table& table) {
  table.Add(
      &BridgeConfig::map_frame,
      {.name = "map_frame", .value_name = "FRAME", .help = "Frame of the map"});
  table.Add(&BridgeConfig::base_frame,
            {.name = "base_frame",
             .value_name = "FRAME",
             .help = "Frame of the robot, on the ground"});
  table.Add(&BridgeConfig::map_from_world,
            {.name = "map_from_world",
             .value_name = "X,Y,Z,YAW | X,Y,Z,QX,QY,QZ,QW",
             .help = "The server's scene in the map (m, rad); '': they are the "
                     "same"});
  table.Add(&BridgeConfig::base_from_camera,
            {.name = "base_from_camera",
             .value_name = "X,Y,Z,QX,QY,QZ,QW",
             .help = "The camera's optical frame on the robot; '': as "
                     "--robot or /tf_static has it"});
  table.Add(&BridgeConfig::robot,
            {.name = "robot",
             .value_name = "FILE",
             .help = "The robot's file, as calibrate writes it: where its "
                     "camera is and by how much its stamps are late; '': "
                     "/tf_static, and not at all"});
  table.Add(&BridgeConfig::rectified,
            {.name = "rectified",
             .help = "The pictures are rectified: P of camera_info counts"});
}

void AddServer(Table& table) {
  table.Add(&BridgeConfig::server,
            {.name = "server",
             .value_name = "HOST:PORT",
             .help = "Relocalization server; several replicas separated by "
                     "commas, in quotes",
             .required = true});
  table.Add(&BridgeConfig::scene,
            {.name = "scene",
             .value_name = "NAME",
             .help = "Scene on the server; '': the server finds out"});
  table.Add(
      &BridgeConfig::tls_ca,
      {.name = "tls_ca",
       .value_name = "FILE",
       .help = "Use TLS for the server and trust these authorities, PEM"});
  table.Add(&BridgeConfig::token_file,
            {.name = "token_file",
             .value_name = "FILE",
             .help = "File with the bearer token for the server"});
  table.Add(&BridgeConfig::one_view_is_enough,
            {.name = "one_view_is_enough",
             .help = "Without map and scan: believe one picture that the "
                     "server is sure of, rather than two different ones"});
  table.Add(&BridgeConfig::ask_interval_s,
            {.name = "ask_interval_s",
             .help = "From an answer to the next question (s)",
             .min = 0,
             .max = 60});
}

void AddProgram(Table& table) {
  table.Add(&BridgeConfig::duration,
            {.name = "duration",
             .help = "Seconds until it ends; 0: it is stopped",
             .min = 0,
             .max = 1e9});
  table.Add(&BridgeConfig::log_level,
            {.name = "log_level",
             .help = "Least important messages that are logged",
             .choices = {"debug", "info", "warn", "error", "off"}});
  table.Add(&BridgeConfig::log_format, {.name = "log_format",
                                        .help = "Form of the log",
                                        .choices = {"text", "json"}});
}

}  // namespace

const config::ConfigTable<BridgeConfig>& BridgeConfigTable() {
  // Immutable; made by the first who asks.
  static const auto* const table = [] {
    auto* made = new Table;
    AddNetwork(*made);
    AddTopics(*made);
    AddFrames(*made);
    AddServer(*made);
    AddProgram(*made);
    return made;
  }();
  return *table;
}

bool IsCompressed(const std::string& topic) {
  return absl::EndsWith(topic, "/compressed") ||
         absl::EndsWith(topic, "/compressedDepth");
}

absl::StatusOr<geometry::Rigid3> ParseTransform(
    const std::vector<std::string>& numbers, const std::string& setting) {
  std::vector<double> values;
  for (const std::string& number : numbers) {
    double value = 0;
    if (!absl::SimpleAtod(number, &value) || !std::isfinite(value)) break;
    values.push_back(value);
  }
  if (values.size() == numbers.size() && values.size() == 4) {
    TL_RETURN_IF_ERROR(base::CheckHeading(setting, values[3]));
    return geometry::Rigid3{
        .rotation = geometry::Rotation3::FromAxisAngle({0, 0, values[3]}),
        .translation = {values[0], values[1], values[2]}};
  }
  if (values.size() == numbers.size() && values.size() == 7) {
    auto made = geometry::RigidFromQuaternion(
        values[6], values[3], values[4], values[5],
        {values[0], values[1], values[2]});
    if (!made.ok()) return base::Annotate(made.status(), setting);
    return made;
  }
  return absl::InvalidArgumentError(
      absl::StrCat(setting,
                   ": write X,Y,Z,YAW (m, rad) or "
                   "X,Y,Z,QX,QY,QZ,QW (m, quaternion)"));
}

std::string BridgeConfig::CameraInfoTopic() const {
  if (!camera_info.empty()) return camera_info;
  const absl::string_view pictures = absl::StripSuffix(image, "/compressed");
  const size_t slash = pictures.rfind('/');
  return slash == absl::string_view::npos
             ? "camera_info"
             : absl::StrCat(pictures.substr(0, slash), "/camera_info");
}

absl::StatusOr<place_finder::PlaceFinderOptions> BridgeConfig::PlaceFinder(
    const SensorsOfFile& sensors) const {
  place_finder::PlaceFinderOptions options;
  options.map_frame = map_frame;
  options.base_frame = base_frame;
  if (!map_from_world.empty()) {
    TL_ASSIGN_OR_RETURN(options.map_from_world,
                        ParseTransform(map_from_world, "map_from_world"));
  }
  options.base_from_camera = sensors.base_from_camera;
  if (!base_from_camera.empty()) {
    TL_ASSIGN_OR_RETURN(options.base_from_camera,
                        ParseTransform(base_from_camera, "base_from_camera"));
  }
  options.camera = {.is_rectified = rectified,
                    .has_depth = !depth.empty(),
                    .delay_s = sensors.camera_delay_s};
  options.laser_delay_s = sensors.laser_delay_s;
  options.ask_interval_s = ask_interval_s;
  options.is_one_view_enough = one_view_is_enough;
  TL_RETURN_IF_ERROR(options.Validate());
  return options;
}

absl::StatusOr<dds::NodeName> BridgeConfig::Node() const {
  dds::NodeName node = {.name_space = name_space, .node = node_name};
  for (const std::string& text : remap) {
    TL_ASSIGN_OR_RETURN(dds::Remapping rule, dds::ParseRemapping(text));
    node.remappings.push_back(std::move(rule));
  }
  TL_RETURN_IF_ERROR(dds::FullTopicName("~/x", node).status());
  return node;
}

absl::StatusOr<dds::DomainOptions> BridgeConfig::Domain(
    const char* ros_domain_id) const {
  dds::DomainOptions domain = {.interface = interface};
  TL_ASSIGN_OR_RETURN(domain.id, dds::DomainId(domain_id, ros_domain_id));
  return domain;
}

absl::Status BridgeConfig::Validate() const {
  if (server.empty()) {
    return absl::InvalidArgumentError(
        "--server: nobody can be asked; HOST:PORT of a treeline-server");
  }
  if (image.empty() || odom.empty() || initial_pose.empty()) {
    return absl::InvalidArgumentError(
        "the topics image, odom and initial_pose are needed");
  }
  TL_RETURN_IF_ERROR(PlaceFinder().status());
  return Node().status();
}

}  // namespace treeline::bridge_app
