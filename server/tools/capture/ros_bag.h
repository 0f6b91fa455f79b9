// A recording of ROS: MCAP, rosbag 2 or rosbag 1 (common/ros2/bag).
//
// Conventions: camera frames as REP 103's "optical" ones (x right, y down, z
// forward), pixel centres at integers as image_geometry has them, depth in mm
// or m (REP 118), z up in the world. Poses come from /tf, at the stamp of each
// picture, or from a topic of Odometry, PoseStamped or
// PoseWithCovarianceStamped and /tf_static.
#ifndef SERVER_TOOLS_CAPTURE_ROS_BAG_H_
#define SERVER_TOOLS_CAPTURE_ROS_BAG_H_

#include <string>

#include "absl/status/statusor.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

bool IsRosBag(const std::string& path);
absl::StatusOr<Capture> OpenRosBag(const std::string& path,
                                   const OpenOptions& options);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_ROS_BAG_H_
