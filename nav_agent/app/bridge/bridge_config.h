// Everything that can be set on `treeline-agent bridge`.
#ifndef NAV_AGENT_APP_BRIDGE_BRIDGE_CONFIG_H_
#define NAV_AGENT_APP_BRIDGE_BRIDGE_CONFIG_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/config/config_table.h"
#include "nav_agent/bridge/dds/domain.h"
#include "nav_agent/bridge/dds/topic_names.h"
#include "nav_agent/bridge/place_finder/place_finder.h"

namespace treeline::bridge_app {

// What environment variables of the bridge start with.
inline constexpr char kBridgePrefix[] = "TREELINE_BRIDGE_";

// What a robot's file says of its sensors, as `treeline-agent calibrate` writes
// it there.
struct SensorsOfFile {
  // nullopt: it does not say.
  std::optional<geometry::Rigid3> base_from_camera = std::nullopt;
  double camera_delay_s = 0;
  double laser_delay_s = 0;
};
using SensorsReader =
    std::function<absl::StatusOr<SensorsOfFile>(const std::string& path)>;

struct BridgeConfig {
  // ---- who is met, and how ----
  // -1: ROS_DOMAIN_ID, or 0.
  int domain_id = -1;
  std::string interface;
  std::string name_space;
  std::string node_name = "treeline";
  std::vector<std::string> remap;
  bool use_sim_time = false;
  // ---- topics ----
  std::string image = "camera/color/image_raw/compressed";
  std::string camera_info;
  std::string depth;
  std::string odom = "odom";
  std::string scan = "scan";
  std::string map = "map";
  std::string initial_pose = "initialpose";
  bool reliable_pictures = false;
  // ---- frames ----
  std::string map_frame = "map";
  std::string base_frame = "base_footprint";
  std::vector<std::string> map_from_world;
  std::vector<std::string> base_from_camera;
  std::string robot;
  bool rectified = false;
  // ---- the server ----
  std::string server;
  std::string scene;
  std::string tls_ca;
  std::string token_file;
  bool one_view_is_enough = false;
  double ask_interval_s = 0.5;
  // ---- the program ----
  double duration = 0;
  std::string log_level = "info";
  std::string log_format = "text";

  // INVALID_ARGUMENT: what a single setting cannot know.
  absl::Status Validate() const;
  // sensors: of the file that `robot` names. What is set here goes before it.
  absl::StatusOr<place_finder::PlaceFinderOptions> PlaceFinder(
      const SensorsOfFile& sensors = {}) const;
  absl::StatusOr<dds::NodeName> Node() const;
  // ROS_DOMAIN_ID as the environment has it; nullptr: it does not.
  absl::StatusOr<dds::DomainOptions> Domain(const char* ros_domain_id) const;
  // camera_info, or the one beside the pictures, as camera drivers name it.
  std::string CameraInfoTopic() const;
};

// The settings; immutable.
const config::ConfigTable<BridgeConfig>& BridgeConfigTable();

// A picture's topic by the conventions of image_transport: what ends with
// "/compressed" or "/compressedDepth" carries CompressedImage.
bool IsCompressed(const std::string& topic);

// X,Y,Z,QX,QY,QZ,QW (m, unit quaternion) or X,Y,Z,YAW (m, rad).
// INVALID_ARGUMENT names `setting`.
absl::StatusOr<geometry::Rigid3> ParseTransform(
    const std::vector<std::string>& numbers, const std::string& setting);

}  // namespace treeline::bridge_app

#endif  // NAV_AGENT_APP_BRIDGE_BRIDGE_CONFIG_H_
