// For tests: the room of testing_captures.h as recordings of ROS.
#ifndef SERVER_TOOLS_CAPTURE_TESTING_ROS_CAPTURES_H_
#define SERVER_TOOLS_CAPTURE_TESTING_ROS_CAPTURES_H_

#include <string>
#include <vector>

#include "common/ros2/bag/testing_bags.h"
#include "server/tools/capture/testing_captures.h"

namespace treeline::capture {

// How a robot's recorder was set up.
struct RosRecorder {
  // Colour as "rgb8" or "bgr8" in Image, or "jpeg" in CompressedImage.
  std::string color = "rgb8";
  // Depth as "16UC1" or "32FC1" in Image, or "compressedDepth"; empty: none.
  std::string depth = "16UC1";
  // "tf": map -> base in /tf and base -> camera in /tf_static; "odometry": the
  // base's in /odom; "pose": the camera's in /camera_pose.
  std::string poses = "tf";
  // Where the depth camera is, with a frame of its own unless it is the
  // identity.
  geometry::Rigid3 color_from_depth{};
};

// In the order of time: 15 pictures a second, depth 5 ms behind colour, poses
// at 30 Hz in between, too.
std::vector<bag::TestingMessage> RosMessages(const TrueScene& scene,
                                             const RosRecorder& recorder);

// Recordings of different recorders, as files or folders of every kind.
void WriteRosMcap(const TrueScene& scene, const std::string& path);
void WriteRosMcapFolder(const TrueScene& scene, const std::string& path);
void WriteRosSqlite(const TrueScene& scene, const std::string& path);
void WriteRos1(const TrueScene& scene, const std::string& path);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_TESTING_ROS_CAPTURES_H_
