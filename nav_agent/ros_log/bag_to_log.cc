#include "nav_agent/ros_log/bag_to_log.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "common/image/decode.h"
#include "common/ros2/conversions/camera_values.h"
#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/bridge/agent_values/laser_values.h"
#include "nav_agent/ros_log/bag_survey.h"
#include "nav_agent/ros_log/log_topics.h"
#include "nav_agent/ros_log/wheels_of_odometry.h"

namespace treeline::ros_log {
namespace {

constexpr int64_t kSameMoment_ns = 20'000'000;
constexpr int kJpegQuality = 95;
constexpr size_t kDepthHeaderBytes = 12;

// "/a/image_raw/compressed" -> "/a/camera_info".
std::string InfoBeside(std::string name) {
  for (const std::string transport : {"/compressed", "/compressedDepth"}) {
    if (absl::EndsWith(name, transport)) {
      name.resize(name.size() - transport.size());
    }
  }
  return absl::StrCat(name.substr(0, name.rfind('/') + 1), "camera_info");
}

geometry::Rigid2 FromAbove(const geometry::Rigid3& pose) {
  return geometry::PlanarPose(pose);
}

// Hands over what is measured, in the second pass.
class LogReader {
 public:
  LogReader(bag::Bag& bag, const BagTopics& topics, BagSurvey& survey,
            const TakeEntry& take)
      : bag_(bag),
        topics_(topics),
        survey_(survey),
        take_(take),
        wheels_(survey.robot.wheel_track_m) {}

  absl::Status Take(const bag::BagMessage& message) {
    const bag::BagTopic& topic = bag_.topics()[message.topic];
    const absl::Status status = TakeByTopic(topic, message);
    if (!absl::IsInvalidArgument(status)) return status;
    // A message that is broken is no reason to lose the others.
    broken_.insert(std::string(status.message()));
    return absl::OkStatus();
  }

  BagLog Finish() && {
    result_.notes = std::move(survey_.notes);
    for (const std::string& what : broken_) {
      result_.notes.push_back(absl::StrCat("left out: ", what));
      if (result_.notes.size() > 20) break;
    }
    return std::move(result_);
  }

 private:
  absl::Status TakeByTopic(const bag::BagTopic& topic,
                           const bag::BagMessage& message) {
    if (message.topic == topics_.scan) return TakeScan(topic, message);
    if (message.topic == topics_.odometry) return TakeOdometry(topic, message);
    if (message.topic == topics_.color) return TakeColor(topic, message);
    if (topic.name == kJointsTopic &&
        topic.type == messages::JointState::kName) {
      TL_ASSIGN_OR_RETURN(
          joints_, bag::Decode<messages::JointState>(topic, message.bytes));
    } else if (topic.name == kImuTopic && topic.type == messages::Imu::kName) {
      TL_ASSIGN_OR_RETURN(imu_,
                          bag::Decode<messages::Imu>(topic, message.bytes));
    } else if (topic.name == kBatteryTopic &&
               topic.type == messages::Float64::kName) {
      TL_ASSIGN_OR_RETURN(battery_,
                          bag::Decode<messages::Float64>(topic, message.bytes));
    } else if (topic.name == kMotorsTopic &&
               topic.type == messages::Bool::kName) {
      TL_ASSIGN_OR_RETURN(motors_,
                          bag::Decode<messages::Bool>(topic, message.bytes));
    } else if (topic.name == kTruthTopic &&
               topic.type == messages::PoseStamped::kName) {
      TL_ASSIGN_OR_RETURN(const auto pose, bag::Decode<messages::PoseStamped>(
                                               topic, message.bytes));
      TL_ASSIGN_OR_RETURN(const geometry::Rigid3 world_from_base,
                          conversions::RigidOf(pose.pose));
      return take_(recording::LogTruePose{
          conversions::TimeOf(pose.header.stamp), world_from_base});
    } else if (topic.name == kEventsTopic &&
               topic.type == messages::Log::kName) {
      return TakeLine(topic, message);
    } else if (topic.name == kCommandTopic) {
      return TakeCommand(topic, message);
    }
    return absl::OkStatus();
  }

  absl::Status TakeLine(const bag::BagTopic& topic,
                        const bag::BagMessage& message) {
    TL_ASSIGN_OR_RETURN(auto line,
                        bag::Decode<messages::Log>(topic, message.bytes));
    if (line.name == kInformationName) {
      return take_(recording::LogInformation{std::move(line.msg)});
    }
    if (line.name != kEventName) return absl::OkStatus();
    return take_(recording::LogEvent{conversions::TimeOf(line.stamp),
                                     std::move(line.msg)});
  }

  absl::Status TakeCommand(const bag::BagTopic& topic,
                           const bag::BagMessage& message) {
    messages::Twist twist;
    base::MonotonicTime stamp =
        conversions::TimeOf(messages::TimeOf(message.time_ns));
    if (topic.type == messages::TwistStamped::kName) {
      TL_ASSIGN_OR_RETURN(
          const auto stamped,
          bag::Decode<messages::TwistStamped>(topic, message.bytes));
      twist = stamped.twist;
      stamp = conversions::TimeOf(stamped.header.stamp);
    } else if (topic.type == messages::Twist::kName) {
      TL_ASSIGN_OR_RETURN(twist,
                          bag::Decode<messages::Twist>(topic, message.bytes));
    } else {
      return absl::OkStatus();
    }
    return take_(recording::LogCommand{
        stamp,
        {.forward_mps = twist.linear.x, .yaw_rate_radps = twist.angular.z}});
  }

  absl::Status TakeScan(const bag::BagTopic& topic,
                        const bag::BagMessage& message) {
    TL_ASSIGN_OR_RETURN(const auto scan,
                        bag::Decode<messages::LaserScan>(topic, message.bytes));
    auto info = agent_values::SensorInfoOf(scan);
    if (!info.ok()) return base::Annotate(info.status(), topic.name);
    if (!laser_ || !(*laser_ == *info)) {
      laser_ = *info;
      TL_RETURN_IF_ERROR(take_(*info));
    }
    ++result_.scans;
    return take_(agent_values::ScanOf(scan));
  }

  absl::Status TakeOdometry(const bag::BagTopic& topic,
                            const bag::BagMessage& message) {
    TL_ASSIGN_OR_RETURN(const auto odometry,
                        bag::Decode<messages::Odometry>(topic, message.bytes));
    TL_ASSIGN_OR_RETURN(const geometry::Rigid3 odom_from_base,
                        conversions::RigidOf(odometry.pose.pose));
    core::BaseReading reading = wheels_.Add(
        conversions::TimeOf(odometry.header.stamp), FromAbove(odom_from_base));
    // What the driver measured is better than differences of poses, unless it
    // leaves it at 0.
    const messages::Twist& twist = odometry.twist.twist;
    const bool has_wheels = TakeWheels(odometry.header.stamp, reading);
    if (has_wheels || twist.linear.x != 0 || twist.angular.z != 0) {
      reading.forward_mps = twist.linear.x;
      reading.yaw_rate_radps = twist.angular.z;
    }
    if (imu_ && imu_->header.stamp == odometry.header.stamp) {
      const auto level = conversions::RigidOf(
          messages::Pose{.position = {}, .orientation = imu_->orientation});
      if (level.ok()) {
        const geometry::Mat3 m = level->rotation.Matrix();
        reading.pitch_rad = -std::asin(std::clamp(m(2, 0), -1.0, 1.0));
        reading.roll_rad = std::atan2(m(2, 1), m(2, 2));
      }
      reading.roll_rate_radps = imu_->angular_velocity.x;
      reading.pitch_rate_radps = imu_->angular_velocity.y;
    }
    if (battery_) reading.battery_v = battery_->data;
    if (motors_) reading.motors_enabled = motors_->data;
    ++result_.readings;
    return take_(reading);
  }

  // Where /joint_states tells of our wheels at that time.
  bool TakeWheels(const messages::Time& stamp,
                  core::BaseReading& reading) const {
    if (!joints_ || !(joints_->header.stamp == stamp) ||
        joints_->position.size() != joints_->name.size()) {
      return false;
    }
    bool has_left = false;
    bool has_right = false;
    for (size_t i = 0; i < joints_->name.size(); ++i) {
      const double way_m = joints_->position[i] * survey_.robot.wheel_radius_m;
      if (joints_->name[i] == kLeftWheel) {
        reading.left_wheel_m = way_m;
        has_left = true;
      } else if (joints_->name[i] == kRightWheel) {
        reading.right_wheel_m = way_m;
        has_right = true;
      }
    }
    return has_left && has_right;
  }

  absl::Status TakeColor(const bag::BagTopic& topic,
                         const bag::BagMessage& message) {
    recording::LogFrame frame;
    TL_ASSIGN_OR_RETURN(const messages::Header header,
                        bag::DecodeHeader(topic, message.bytes));
    frame.stamp = conversions::TimeOf(header.stamp);
    frame.sequence = result_.frames;
    TL_ASSIGN_OR_RETURN(frame.color, ColorFile(topic, message.bytes));
    const auto place = DepthAt(messages::Nanoseconds(header.stamp));
    if (place) {
      TL_ASSIGN_OR_RETURN(const auto bytes, bag_.Fetch(*place));
      TL_ASSIGN_OR_RETURN(frame.depth,
                          DepthFile(bag_.topics()[*topics_.depth], bytes));
    }
    ++result_.frames;
    return take_(std::move(frame));
  }

  // JPEG or PNG as it is, else as JPEG.
  static absl::StatusOr<std::string> ColorFile(const bag::BagTopic& topic,
                                               std::span<const uint8_t> bytes) {
    if (topic.type == messages::CompressedImage::kName) {
      TL_ASSIGN_OR_RETURN(const auto picture,
                          bag::Decode<messages::CompressedImage>(topic, bytes));
      std::string file(picture.data.begin(), picture.data.end());
      if (image::SniffFormat(file) != image::ImageFormat::kUnknown) return file;
      return absl::InvalidArgumentError(
          absl::StrCat(topic.name, ": is neither JPEG nor PNG"));
    }
    TL_ASSIGN_OR_RETURN(const auto picture,
                        bag::Decode<messages::Image>(topic, bytes));
    TL_ASSIGN_OR_RETURN(const image::ColorImage color,
                        conversions::ColorOf(picture));
    return image::EncodeJpeg(color, kJpegQuality);
  }

  // A PNG in mm.
  static absl::StatusOr<std::string> DepthFile(const bag::BagTopic& topic,
                                               std::span<const uint8_t> bytes) {
    if (topic.type == messages::Image::kName) {
      TL_ASSIGN_OR_RETURN(const auto picture,
                          bag::Decode<messages::Image>(topic, bytes));
      TL_ASSIGN_OR_RETURN(const image::DepthImage depth,
                          conversions::DepthOf(picture));
      return image::EncodeDepthPng(depth);
    }
    TL_ASSIGN_OR_RETURN(const auto picture,
                        bag::Decode<messages::CompressedImage>(topic, bytes));
    if (absl::StrContains(picture.format, "16UC1") &&
        picture.data.size() > kDepthHeaderBytes) {
      std::string file(picture.data.begin() + kDepthHeaderBytes,
                       picture.data.end());
      if (image::SniffFormat(file) == image::ImageFormat::kPng) return file;
    }
    TL_ASSIGN_OR_RETURN(const image::DepthImage depth,
                        conversions::DepthOf(picture));
    return image::EncodeDepthPng(depth);
  }

  std::optional<bag::BagPlace> DepthAt(int64_t stamp_ns) const {
    if (!topics_.depth) return std::nullopt;
    const auto found = survey_.pictures.find(*topics_.depth);
    if (found == survey_.pictures.end()) return std::nullopt;
    const auto& depth = found->second;
    const auto next = depth.lower_bound(stamp_ns);
    std::optional<bag::BagPlace> best;
    double best_ns = kSameMoment_ns;
    const auto consider = [&](const auto& moment) {
      const double apart_ns = std::abs(static_cast<double>(moment.first) -
                                       static_cast<double>(stamp_ns));
      if (apart_ns > best_ns) return;
      best_ns = apart_ns;
      best = moment.second;
    };
    if (next != depth.end()) consider(*next);
    if (next != depth.begin()) consider(*std::prev(next));
    return best;
  }

  bag::Bag& bag_;
  const BagTopics& topics_;
  BagSurvey& survey_;
  const TakeEntry& take_;
  WheelsOfOdometry wheels_;
  std::optional<core::RangeSensorInfo> laser_;
  std::optional<messages::JointState> joints_;
  std::optional<messages::Imu> imu_;
  std::optional<messages::Float64> battery_;
  std::optional<messages::Bool> motors_;
  BagLog result_;
  std::set<std::string> broken_;
};

// Where sensors are on the robot, and the cameras, before what is measured.
absl::Status TakeDescription(const bag::Bag& bag, const BagTopics& topics,
                             BagSurvey& survey, const TakeEntry& take) {
  core::RobotModel robot = survey.robot;
  const int64_t time_ns = survey.first_ns;
  const std::string base_frame = survey.BaseFrame(topics.odometry);
  const std::string color_frame = survey.FrameOf(topics.color);
  const auto place = [&](const std::string& frame,
                         const char* what) -> std::optional<geometry::Rigid3> {
    auto found = survey.transforms.Find(base_frame, frame, time_ns);
    if (found.ok()) return *found;
    survey.notes.push_back(absl::StrCat("/tf does not tell where ", what, " (",
                                        frame, ") is on ", base_frame,
                                        "; it is taken to be at its origin"));
    return std::nullopt;
  };
  if (topics.scan) {
    robot.base_from_laser = place(survey.FrameOf(topics.scan), "the laser")
                                .value_or(geometry::Rigid3());
  }
  if (topics.color) {
    const auto camera = place(color_frame, "the camera");
    if (camera) robot.base_from_camera = *camera;
  }
  if (!survey.has_robot) {
    survey.notes.push_back(
        "the measures of the robot are those of the default robot; give your "
        "own where they matter");
  }
  TL_RETURN_IF_ERROR(take(robot));
  if (!topics.color) return absl::OkStatus();
  const auto info =
      survey.cameras.find(InfoBeside(bag.topics()[*topics.color].name));
  if (info == survey.cameras.end()) {
    survey.notes.push_back("pictures have no camera_info");
    return absl::OkStatus();
  }
  camera::RgbdCalibration calibration;
  TL_ASSIGN_OR_RETURN(calibration.color,
                      conversions::CameraOf(info->second, false));
  calibration.depth = calibration.color;
  if (topics.depth) {
    const auto depth_info =
        survey.cameras.find(InfoBeside(bag.topics()[*topics.depth].name));
    if (depth_info != survey.cameras.end()) {
      TL_ASSIGN_OR_RETURN(calibration.depth,
                          conversions::CameraOf(depth_info->second, false));
    }
    const auto color_from_depth = survey.transforms.Find(
        color_frame, survey.FrameOf(topics.depth), time_ns);
    if (color_from_depth.ok()) {
      calibration.color_from_depth = *color_from_depth;
    }
  }
  return take(calibration);
}

}  // namespace

absl::StatusOr<BagLog> ReadBagAsLog(bag::Bag& bag, const BagLogOptions& options,
                                    const TakeEntry& take) {
  TL_ASSIGN_OR_RETURN(BagSurvey survey, SurveyBag(bag));
  TL_ASSIGN_OR_RETURN(const BagTopics topics,
                      ChooseTopics(bag, options, survey));
  if (!topics.odometry) {
    survey.notes.push_back(
        "there is no odometry (nav_msgs/Odometry): the log has no wheel "
        "readings");
  }
  TL_RETURN_IF_ERROR(TakeDescription(bag, topics, survey, take));
  LogReader reader(bag, topics, survey, take);
  TL_RETURN_IF_ERROR(bag.Read(
      [&](const bag::BagMessage& message) { return reader.Take(message); }));
  return std::move(reader).Finish();
}

}  // namespace treeline::ros_log
