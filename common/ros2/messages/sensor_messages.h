// Messages of sensor_msgs.
#ifndef COMMON_ROS2_MESSAGES_SENSOR_MESSAGES_H_
#define COMMON_ROS2_MESSAGES_SENSOR_MESSAGES_H_

#include <array>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/message_fields.h"

namespace treeline::messages {

// Angles in rad, times in s, ranges in m. The stamp is of the first beam.
struct LaserScan {
  Header header;
  float angle_min = 0;
  float angle_max = 0;
  float angle_increment = 0;
  float time_increment = 0;
  float scan_time = 0;
  float range_min = 0;
  float range_max = 0;
  std::vector<float> ranges;
  std::vector<float> intensities;

  bool operator==(const LaserScan&) const = default;
  static constexpr char kName[] = "sensor_msgs/msg/LaserScan";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("header", &LaserScan::header),
        Named("angle_min", &LaserScan::angle_min),
        Named("angle_max", &LaserScan::angle_max),
        Named("angle_increment", &LaserScan::angle_increment),
        Named("time_increment", &LaserScan::time_increment),
        Named("scan_time", &LaserScan::scan_time),
        Named("range_min", &LaserScan::range_min),
        Named("range_max", &LaserScan::range_max),
        Named("ranges", &LaserScan::ranges),
        Named("intensities", &LaserScan::intensities));
  }
};

// rad, rad/s; m and m/s of what slides.
struct JointState {
  Header header;
  std::vector<std::string> name;
  std::vector<double> position;
  std::vector<double> velocity;
  std::vector<double> effort;

  bool operator==(const JointState&) const = default;
  static constexpr char kName[] = "sensor_msgs/msg/JointState";
  static constexpr auto Fields() {
    return std::make_tuple(Named("header", &JointState::header),
                           Named("name", &JointState::name),
                           Named("position", &JointState::position),
                           Named("velocity", &JointState::velocity),
                           Named("effort", &JointState::effort));
  }
};

// A covariance that begins with -1: that quantity is not measured.
struct Imu {
  Header header;
  Quaternion orientation;
  std::array<double, 9> orientation_covariance = {};
  Vector3 angular_velocity;
  std::array<double, 9> angular_velocity_covariance = {};
  Vector3 linear_acceleration;
  std::array<double, 9> linear_acceleration_covariance = {};

  bool operator==(const Imu&) const = default;
  static constexpr char kName[] = "sensor_msgs/msg/Imu";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("header", &Imu::header), Named("orientation", &Imu::orientation),
        Named("orientation_covariance", &Imu::orientation_covariance),
        Named("angular_velocity", &Imu::angular_velocity),
        Named("angular_velocity_covariance", &Imu::angular_velocity_covariance),
        Named("linear_acceleration", &Imu::linear_acceleration),
        Named("linear_acceleration_covariance",
              &Imu::linear_acceleration_covariance));
  }
};

// What is not measured is NaN; of unknown cells there are none.
struct BatteryState {
  static constexpr uint8_t kUnknown = 0;
  static constexpr uint8_t kCharging = 1;
  static constexpr uint8_t kDischarging = 2;
  static constexpr uint8_t kNotCharging = 3;
  static constexpr uint8_t kFull = 4;

  Header header = {};
  float voltage = 0;
  float temperature = 0;
  float current = 0;
  float charge = 0;
  float capacity = 0;
  float design_capacity = 0;
  // From 0 to 1.
  float percentage = 0;
  uint8_t power_supply_status = kUnknown;
  uint8_t power_supply_health = 0;
  uint8_t power_supply_technology = 0;
  bool present = false;
  std::vector<float> cell_voltage = {};
  std::vector<float> cell_temperature = {};
  std::string location = {};
  std::string serial_number = {};

  bool operator==(const BatteryState&) const = default;
  static constexpr char kName[] = "sensor_msgs/msg/BatteryState";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("header", &BatteryState::header),
        Named("voltage", &BatteryState::voltage),
        Named("temperature", &BatteryState::temperature),
        Named("current", &BatteryState::current),
        Named("charge", &BatteryState::charge),
        Named("capacity", &BatteryState::capacity),
        Named("design_capacity", &BatteryState::design_capacity),
        Named("percentage", &BatteryState::percentage),
        Named("power_supply_status", &BatteryState::power_supply_status),
        Named("power_supply_health", &BatteryState::power_supply_health),
        Named("power_supply_technology",
              &BatteryState::power_supply_technology),
        Named("present", &BatteryState::present),
        Named("cell_voltage", &BatteryState::cell_voltage),
        Named("cell_temperature", &BatteryState::cell_temperature),
        Named("location", &BatteryState::location),
        Named("serial_number", &BatteryState::serial_number));
  }
};

struct PointField {
  static constexpr uint8_t kInt8 = 1;
  static constexpr uint8_t kUint8 = 2;
  static constexpr uint8_t kInt16 = 3;
  static constexpr uint8_t kUint16 = 4;
  static constexpr uint8_t kInt32 = 5;
  static constexpr uint8_t kUint32 = 6;
  static constexpr uint8_t kFloat32 = 7;
  static constexpr uint8_t kFloat64 = 8;

  std::string name;
  uint32_t offset = 0;
  uint8_t datatype = 0;
  uint32_t count = 0;

  bool operator==(const PointField&) const = default;
  static constexpr char kName[] = "sensor_msgs/msg/PointField";
  static constexpr auto Fields() {
    return std::make_tuple(Named("name", &PointField::name),
                           Named("offset", &PointField::offset),
                           Named("datatype", &PointField::datatype),
                           Named("count", &PointField::count));
  }
};

struct PointCloud2 {
  Header header;
  uint32_t height = 0;
  uint32_t width = 0;
  std::vector<PointField> fields;
  bool is_bigendian = false;
  uint32_t point_step = 0;
  uint32_t row_step = 0;
  std::vector<uint8_t> data;
  bool is_dense = false;

  bool operator==(const PointCloud2&) const = default;
  static constexpr char kName[] = "sensor_msgs/msg/PointCloud2";
  static constexpr auto Fields() {
    return std::make_tuple(Named("header", &PointCloud2::header),
                           Named("height", &PointCloud2::height),
                           Named("width", &PointCloud2::width),
                           Named("fields", &PointCloud2::fields),
                           Named("is_bigendian", &PointCloud2::is_bigendian),
                           Named("point_step", &PointCloud2::point_step),
                           Named("row_step", &PointCloud2::row_step),
                           Named("data", &PointCloud2::data),
                           Named("is_dense", &PointCloud2::is_dense));
  }
};

// encoding: "rgb8", "16UC1", ...; step: bytes from one row to the next.
struct Image {
  Header header;
  uint32_t height = 0;
  uint32_t width = 0;
  std::string encoding;
  uint8_t is_bigendian = 0;
  uint32_t step = 0;
  std::vector<uint8_t> data;

  bool operator==(const Image&) const = default;
  static constexpr char kName[] = "sensor_msgs/msg/Image";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("header", &Image::header), Named("height", &Image::height),
        Named("width", &Image::width), Named("encoding", &Image::encoding),
        Named("is_bigendian", &Image::is_bigendian),
        Named("step", &Image::step), Named("data", &Image::data));
  }
};

struct CompressedImage {
  Header header;
  std::string format;
  std::vector<uint8_t> data;

  bool operator==(const CompressedImage&) const = default;
  static constexpr char kName[] = "sensor_msgs/msg/CompressedImage";
  static constexpr auto Fields() {
    return std::make_tuple(Named("header", &CompressedImage::header),
                           Named("format", &CompressedImage::format),
                           Named("data", &CompressedImage::data));
  }
};

struct RegionOfInterest {
  uint32_t x_offset = 0;
  uint32_t y_offset = 0;
  uint32_t height = 0;
  uint32_t width = 0;
  bool do_rectify = false;

  bool operator==(const RegionOfInterest&) const = default;
  static constexpr char kName[] = "sensor_msgs/msg/RegionOfInterest";
  static constexpr auto Fields() {
    return std::make_tuple(Named("x_offset", &RegionOfInterest::x_offset),
                           Named("y_offset", &RegionOfInterest::y_offset),
                           Named("height", &RegionOfInterest::height),
                           Named("width", &RegionOfInterest::width),
                           Named("do_rectify", &RegionOfInterest::do_rectify));
  }
};

// k, r and p are row-major; pixel centres are at integer coordinates.
struct CameraInfo {
  Header header;
  uint32_t height = 0;
  uint32_t width = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k = {};
  std::array<double, 9> r = {};
  std::array<double, 12> p = {};
  uint32_t binning_x = 0;
  uint32_t binning_y = 0;
  RegionOfInterest roi;

  bool operator==(const CameraInfo&) const = default;
  static constexpr char kName[] = "sensor_msgs/msg/CameraInfo";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("header", &CameraInfo::header),
        Named("height", &CameraInfo::height),
        Named("width", &CameraInfo::width),
        Named("distortion_model", &CameraInfo::distortion_model),
        Named("d", &CameraInfo::d), Named("k", &CameraInfo::k),
        Named("r", &CameraInfo::r), Named("p", &CameraInfo::p),
        Named("binning_x", &CameraInfo::binning_x),
        Named("binning_y", &CameraInfo::binning_y),
        Named("roi", &CameraInfo::roi));
  }
};

}  // namespace treeline::messages

#endif  // COMMON_ROS2_MESSAGES_SENSOR_MESSAGES_H_
