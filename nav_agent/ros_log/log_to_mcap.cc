#include "nav_agent/ros_log/log_to_mcap.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "absl/memory/memory.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "common/ros2/conversions/camera_values.h"
#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/bridge/agent_values/laser_values.h"
#include "nav_agent/ros_log/log_topics.h"
#include "nav_agent/ros_log/robot_text.h"

namespace treeline::ros_log {
namespace {

constexpr double kMillimetre = 0.001;
constexpr double kFarthest_mm = 65534;
// In front of a PNG of the transport for depth.
constexpr size_t kDepthHeaderBytes = 12;

int64_t Nanoseconds(base::MonotonicTime stamp) {
  return messages::Nanoseconds(conversions::StampOf(stamp));
}

messages::Header HeaderOf(int64_t time_ns, const char* frame) {
  return {.stamp = messages::TimeOf(time_ns), .frame_id = frame};
}

messages::TransformStamped Transform(int64_t time_ns, const char* parent,
                                     const char* child,
                                     const geometry::Rigid3& value) {
  return {.header = HeaderOf(time_ns, parent),
          .child_frame_id = child,
          .transform = conversions::TransformOf(value)};
}

messages::Log LineOf(int64_t time_ns, const char* name,
                     const std::string& text) {
  messages::Log line;
  line.stamp = messages::TimeOf(time_ns);
  line.name = name;
  line.msg = text;
  return line;
}

// The PNG with mm as its unit, as 16UC1 has it.
absl::StatusOr<std::string> InMillimetres(const recording::LogFrame& frame) {
  if (frame.depth_unit_m == kMillimetre) return frame.depth;
  TL_ASSIGN_OR_RETURN(image::DepthImage depth,
                      image::DecodeDepthPng(frame.depth, kMillimetre));
  const double factor = frame.depth_unit_m / kMillimetre;
  for (uint16_t& value : depth.values) {
    const double depth_mm =
        image::IsMeasured(value) ? std::round(factor * value) : 0;
    value = depth_mm > kFarthest_mm ? 0 : static_cast<uint16_t>(depth_mm);
  }
  return image::EncodeDepthPng(depth);
}

}  // namespace

absl::StatusOr<std::unique_ptr<LogToMcap>> LogToMcap::Open(
    const std::string& path, mcap::Compression compression) {
  mcap::McapWriterOptions options;
  options.compression = compression;
  TL_ASSIGN_OR_RETURN(std::unique_ptr<mcap::McapWriter> writer,
                      mcap::McapWriter::Open(path, options));
  return absl::WrapUnique(new LogToMcap(std::move(writer)));
}

template <messages::Message M>
absl::Status LogToMcap::Write(const char* topic, int64_t time_ns,
                              const M& message) {
  const auto found = channels_.find(topic);
  const uint16_t channel =
      found != channels_.end()
          ? found->second
          : writer_->AddChannel(topic, M::kName, messages::SchemaText<M>());
  channels_[topic] = channel;
  newest_ns_ = std::max(newest_ns_, time_ns);
  ++messages_;
  // MCAP's times have no sign.
  return writer_->Write(channel,
                        static_cast<uint64_t>(std::max<int64_t>(time_ns, 0)),
                        messages::Encode(message));
}

absl::Status LogToMcap::Add(const recording::LogEntry& entry) {
  return std::visit([this](const auto& value) { return Take(value); }, entry);
}

absl::Status LogToMcap::AddMap(const messages::OccupancyGrid& map) {
  return Write(kMapTopic, newest_ns_, map);
}

absl::Status LogToMcap::AddPath(const messages::Path& path) {
  return Write(kPathTopic, newest_ns_, path);
}

absl::Status LogToMcap::Take(const recording::LogInformation& information) {
  information_.push_back(information.text);
  return absl::OkStatus();
}

absl::Status LogToMcap::Take(const core::RangeSensorInfo& info) {
  laser_ = info;
  is_description_written_ = false;
  return absl::OkStatus();
}

absl::Status LogToMcap::Take(const camera::RgbdCalibration& calibration) {
  calibration_ = calibration;
  is_description_written_ = false;
  if (calibration.depth_scale != 1) {
    notes_.insert("the calibration's depth scale has no place in camera_info");
  }
  return absl::OkStatus();
}

absl::Status LogToMcap::Take(const core::RobotModel& robot) {
  robot_ = robot;
  has_robot_ = true;
  is_description_written_ = false;
  odometry_.reset();
  return absl::OkStatus();
}

absl::Status LogToMcap::WriteDescription(int64_t time_ns) {
  for (const std::string& text : information_) {
    TL_RETURN_IF_ERROR(
        Write(kEventsTopic, time_ns, LineOf(time_ns, kInformationName, text)));
  }
  information_.clear();
  if (is_description_written_) return absl::OkStatus();
  is_description_written_ = true;
  if (has_robot_) {
    TL_RETURN_IF_ERROR(Write(kRobotTopic, time_ns,
                             messages::String{.data = RobotText(robot_)}));
  }
  messages::TFMessage frames;
  if (laser_) {
    frames.transforms.push_back(
        Transform(time_ns, kBaseFrame, kLaserFrame, robot_.base_from_laser));
  }
  if (calibration_) {
    frames.transforms.push_back(Transform(
        time_ns, kBaseFrame, kColorFrame,
        camera::PoseOfSensor(robot_.base_from_camera, calibration_->pose_sensor,
                             camera::RgbdSensor::kColor, *calibration_)));
    frames.transforms.push_back(Transform(time_ns, kColorFrame, kDepthFrame,
                                          calibration_->color_from_depth));
  }
  return frames.transforms.empty() ? absl::OkStatus()
                                   : Write(kStaticTopic, time_ns, frames);
}

absl::Status LogToMcap::Take(const core::LaserScan& scan) {
  const int64_t time_ns = Nanoseconds(scan.stamp);
  if (!laser_) {
    notes_.insert("scans before the laser's description were left out");
    return absl::OkStatus();
  }
  TL_RETURN_IF_ERROR(WriteDescription(time_ns));
  return Write(kScanTopic, time_ns,
               agent_values::MessageOf(scan, *laser_, kLaserFrame));
}

absl::Status LogToMcap::Take(const core::BaseReading& reading) {
  const int64_t time_ns = Nanoseconds(reading.stamp);
  TL_RETURN_IF_ERROR(WriteDescription(time_ns));
  if (!odometry_) {
    TL_ASSIGN_OR_RETURN(
        odometry_,
        core::SlopeOdometry::Create({.wheel_track_m = robot_.wheel_track_m}));
  }
  // One that it refuses moves nothing.
  odometry_->Add(reading).IgnoreError();
  const geometry::Rigid3 odom_from_base = odometry_->OdomFromBase();

  messages::JointState wheels;
  wheels.header = HeaderOf(time_ns, "");
  wheels.name = {kLeftWheel, kRightWheel};
  wheels.position = {reading.left_wheel_m / robot_.wheel_radius_m,
                     reading.right_wheel_m / robot_.wheel_radius_m};
  TL_RETURN_IF_ERROR(Write(kJointsTopic, time_ns, wheels));
  messages::Imu imu;
  imu.header = HeaderOf(time_ns, kBaseFrame);
  imu.orientation =
      conversions::PoseOf(
          {geometry::Rotation3::FromAxisAngle({0, reading.pitch_rad, 0}) *
               geometry::Rotation3::FromAxisAngle({reading.roll_rad, 0, 0}),
           {}})
          .orientation;
  imu.angular_velocity = {.x = reading.roll_rate_radps,
                          .y = reading.pitch_rate_radps,
                          .z = reading.yaw_rate_radps};
  imu.linear_acceleration_covariance[0] = -1;
  TL_RETURN_IF_ERROR(Write(kImuTopic, time_ns, imu));
  TL_RETURN_IF_ERROR(Write(kBatteryTopic, time_ns,
                           messages::Float64{.data = reading.battery_v}));
  TL_RETURN_IF_ERROR(Write(kMotorsTopic, time_ns,
                           messages::Bool{.data = reading.motors_enabled}));
  TL_RETURN_IF_ERROR(
      Write(kTransformsTopic, time_ns,
            messages::TFMessage{
                {Transform(time_ns, kOdomFrame, kBaseFrame, odom_from_base)}}));
  // Last: who reads it has all of the others.
  messages::Odometry odometry;
  odometry.header = HeaderOf(time_ns, kOdomFrame);
  odometry.child_frame_id = kBaseFrame;
  odometry.pose.pose = conversions::PoseOf(odom_from_base);
  odometry.twist.twist.linear.x = reading.forward_mps;
  odometry.twist.twist.angular.z = reading.yaw_rate_radps;
  return Write(kOdometryTopic, time_ns, odometry);
}

absl::Status LogToMcap::Take(const recording::LogFrame& frame) {
  const int64_t time_ns = Nanoseconds(frame.stamp);
  TL_RETURN_IF_ERROR(WriteDescription(time_ns));
  if (calibration_) {
    const auto color = conversions::InfoOf(calibration_->color,
                                           HeaderOf(time_ns, kColorFrame));
    const auto depth = conversions::InfoOf(calibration_->depth,
                                           HeaderOf(time_ns, kDepthFrame));
    if (color.ok() && depth.ok()) {
      TL_RETURN_IF_ERROR(Write(kColorInfoTopic, time_ns, *color));
      TL_RETURN_IF_ERROR(Write(kDepthInfoTopic, time_ns, *depth));
    } else {
      notes_.insert(
          std::string((color.ok() ? depth : color).status().message()));
    }
  }
  messages::CompressedImage picture;
  if (!frame.depth.empty()) {
    const auto png = InMillimetres(frame);
    if (!png.ok()) {
      notes_.insert("depth maps that are no PNG were left out");
    } else {
      if (frame.depth_unit_m != kMillimetre) {
        notes_.insert("depth was rounded to millimetres");
      }
      picture.header = HeaderOf(time_ns, kDepthFrame);
      picture.format = "16UC1; compressedDepth png";
      picture.data.assign(kDepthHeaderBytes, 0);
      picture.data.insert(picture.data.end(), png->begin(), png->end());
      TL_RETURN_IF_ERROR(Write(kDepthTopic, time_ns, picture));
    }
  }
  picture.header = HeaderOf(time_ns, kColorFrame);
  picture.format = image::SniffFormat(frame.color) == image::ImageFormat::kPng
                       ? "rgb8; png compressed rgb8"
                       : "rgb8; jpeg compressed rgb8";
  picture.data.assign(frame.color.begin(), frame.color.end());
  return Write(kColorTopic, time_ns, picture);
}

absl::Status LogToMcap::Take(const recording::LogTruePose& pose) {
  const int64_t time_ns = Nanoseconds(pose.stamp);
  TL_RETURN_IF_ERROR(WriteDescription(time_ns));
  return Write(
      kTruthTopic, time_ns,
      messages::PoseStamped{.header = HeaderOf(time_ns, kMapFrame),
                            .pose = conversions::PoseOf(pose.world_from_base)});
}

absl::Status LogToMcap::Take(const recording::LogEvent& event) {
  const int64_t time_ns = Nanoseconds(event.stamp);
  TL_RETURN_IF_ERROR(WriteDescription(time_ns));
  return Write(kEventsTopic, time_ns, LineOf(time_ns, kEventName, event.text));
}

absl::Status LogToMcap::Take(const recording::LogCommand& command) {
  const int64_t time_ns = Nanoseconds(command.stamp);
  TL_RETURN_IF_ERROR(WriteDescription(time_ns));
  messages::TwistStamped twist;
  twist.header = HeaderOf(time_ns, kBaseFrame);
  twist.twist.linear.x = command.command.forward_mps;
  twist.twist.angular.z = command.command.yaw_rate_radps;
  return Write(kCommandTopic, time_ns, twist);
}

}  // namespace treeline::ros_log
