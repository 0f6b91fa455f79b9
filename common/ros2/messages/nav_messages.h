// Messages of nav_msgs.
#ifndef COMMON_ROS2_MESSAGES_NAV_MESSAGES_H_
#define COMMON_ROS2_MESSAGES_NAV_MESSAGES_H_

#include <array>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/message_fields.h"

namespace treeline::messages {

// pose is in header.frame_id, twist in child_frame_id.
struct Odometry {
  Header header;
  std::string child_frame_id;
  PoseWithCovariance pose;
  TwistWithCovariance twist;

  bool operator==(const Odometry&) const = default;
  static constexpr char kName[] = "nav_msgs/msg/Odometry";
  static constexpr auto Fields() {
    return std::make_tuple(Named("header", &Odometry::header),
                           Named("child_frame_id", &Odometry::child_frame_id),
                           Named("pose", &Odometry::pose),
                           Named("twist", &Odometry::twist));
  }
};

// The origin is the lower left corner of cell (0, 0); resolution in m.
struct MapMetaData {
  Time map_load_time;
  float resolution = 0;
  uint32_t width = 0;
  uint32_t height = 0;
  Pose origin;

  bool operator==(const MapMetaData&) const = default;
  static constexpr char kName[] = "nav_msgs/msg/MapMetaData";
  static constexpr auto Fields() {
    return std::make_tuple(Named("map_load_time", &MapMetaData::map_load_time),
                           Named("resolution", &MapMetaData::resolution),
                           Named("width", &MapMetaData::width),
                           Named("height", &MapMetaData::height),
                           Named("origin", &MapMetaData::origin));
  }
};

// Rows from the bottom; 0 to 100: the chance of an obstacle, -1: unknown.
struct OccupancyGrid {
  Header header;
  MapMetaData info;
  std::vector<int8_t> data;

  bool operator==(const OccupancyGrid&) const = default;
  static constexpr char kName[] = "nav_msgs/msg/OccupancyGrid";
  static constexpr auto Fields() {
    return std::make_tuple(Named("header", &OccupancyGrid::header),
                           Named("info", &OccupancyGrid::info),
                           Named("data", &OccupancyGrid::data));
  }
};

struct Path {
  Header header;
  std::vector<PoseStamped> poses;

  bool operator==(const Path&) const = default;
  static constexpr char kName[] = "nav_msgs/msg/Path";
  static constexpr auto Fields() {
    return std::make_tuple(Named("header", &Path::header),
                           Named("poses", &Path::poses));
  }
};

}  // namespace treeline::messages

#endif  // COMMON_ROS2_MESSAGES_NAV_MESSAGES_H_
