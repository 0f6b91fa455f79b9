// The topics and frames under which an agent's log is written as MCAP; the same
// names are looked for when one is read.
#ifndef NAV_AGENT_ROS_LOG_LOG_TOPICS_H_
#define NAV_AGENT_ROS_LOG_LOG_TOPICS_H_

namespace treeline::ros_log {

inline constexpr char kScanTopic[] = "/scan";
inline constexpr char kOdometryTopic[] = "/odom";
inline constexpr char kJointsTopic[] = "/joint_states";
inline constexpr char kImuTopic[] = "/imu";
inline constexpr char kBatteryTopic[] = "/battery_voltage";
inline constexpr char kMotorsTopic[] = "/motors_enabled";
inline constexpr char kCommandTopic[] = "/cmd_vel";
inline constexpr char kTruthTopic[] = "/ground_truth";
inline constexpr char kRobotTopic[] = "/robot_measures";
inline constexpr char kEventsTopic[] = "/rosout";
inline constexpr char kTransformsTopic[] = "/tf";
inline constexpr char kStaticTopic[] = "/tf_static";
inline constexpr char kColorTopic[] = "/camera/color/image_raw/compressed";
inline constexpr char kColorInfoTopic[] = "/camera/color/camera_info";
inline constexpr char kDepthTopic[] = "/camera/depth/image_raw/compressedDepth";
inline constexpr char kDepthInfoTopic[] = "/camera/depth/camera_info";
inline constexpr char kMapTopic[] = "/map";
inline constexpr char kPathTopic[] = "/path";

inline constexpr char kMapFrame[] = "map";
inline constexpr char kOdomFrame[] = "odom";
inline constexpr char kBaseFrame[] = "base_link";
inline constexpr char kLaserFrame[] = "laser";
inline constexpr char kColorFrame[] = "camera_color_optical_frame";
inline constexpr char kDepthFrame[] = "camera_depth_optical_frame";

inline constexpr char kLeftWheel[] = "left_wheel";
inline constexpr char kRightWheel[] = "right_wheel";

// Who says a line of /rosout: what happened, and what the recording is of.
inline constexpr char kEventName[] = "treeline";
inline constexpr char kInformationName[] = "treeline.recording";

}  // namespace treeline::ros_log

#endif  // NAV_AGENT_ROS_LOG_LOG_TOPICS_H_
