#include "nav_agent/app/hardware/robot_hardware.h"

#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/config/config_table.h"
#include "nav_agent/drivers/camera/openni/openni2.h"
#include "nav_agent/drivers/camera/openni/openni_camera.h"
#include "nav_agent/drivers/camera/openni/openni_device.h"
#include "nav_agent/drivers/stream/stream_address.h"

namespace treeline::hardware {
namespace {

constexpr int kLaserBaud = 115200;
constexpr int kLaserPort = 10940;

// HardwareConfig as a file has it: flat.
struct HardwareFile : core::MeasuredOdometryNoise {
  std::string laser;
  std::string base;
  std::string rear_laser;
  std::string camera = "none";
  double front_m = core::RobotModel().front_m;
  double rear_m = core::RobotModel().rear_m;
  double half_width_m = core::RobotModel().half_width_m;
  double height_m = core::RobotModel().height_m;
  double wheel_track_m = core::RobotModel().wheel_track_m;
  double max_forward_mps = core::RobotModel().max_forward_mps;
  double laser_x_m = core::RobotModel().base_from_laser.translation.x;
  double laser_y_m = core::RobotModel().base_from_laser.translation.y;
  double laser_z_m = core::RobotModel().base_from_laser.translation.z;
  double laser_yaw_rad = 0;
  double rear_laser_x_m = core::RobotModel().base_from_rear_laser.translation.x;
  double rear_laser_y_m = core::RobotModel().base_from_rear_laser.translation.y;
  double rear_laser_z_m = core::RobotModel().base_from_rear_laser.translation.z;
  double rear_laser_yaw_rad = std::numbers::pi;
  double camera_x_m = core::RobotModel().base_from_camera.translation.x;
  double camera_y_m = core::RobotModel().base_from_camera.translation.y;
  double camera_z_m = core::RobotModel().base_from_camera.translation.z;
  double camera_down_rad = 0.21;
  double left_wheel_scale = 1;
  double right_wheel_scale = 1;
  double laser_delay_s = 0;
  double camera_delay_s = 0;
  std::string charging_contacts;
};

const config::ConfigTable<HardwareFile>& HardwareTable() {
  // Immutable; made by the first who asks.
  static const auto* const table = [] {
    auto* made = new config::ConfigTable<HardwareFile>;
    made->Add(&HardwareFile::laser,
              {.name = "laser", .help = "A Hokuyo laser", .required = true});
    made->Add(&HardwareFile::base,
              {.name = "base", .help = "A Segway RMP100", .required = true});
    made->Add(&HardwareFile::rear_laser,
              {.name = "rear_laser",
               .help = "A second Hokuyo laser, that looks back"});
    made->Add(&HardwareFile::camera, {.name = "camera",
                                      .help = "An RGB-D camera",
                                      .choices = {"none", "openni"}});
    made->Add(&HardwareFile::charging_contacts,
              {.name = "charging_contacts",
               .help = "At which end of the robot they are; '': as docks say",
               .choices = {"", "front", "rear"}});
    const auto add = [made](double HardwareFile::*field, const char* name,
                            const char* help, double min, double max) {
      made->Add(field, {.name = name, .help = help, .min = min, .max = max});
    };
    add(&HardwareFile::front_m, "front_m", "Axle to front edge", 0.01, 5);
    add(&HardwareFile::rear_m, "rear_m", "Axle to rear edge", 0.01, 5);
    add(&HardwareFile::half_width_m, "half_width_m", "Middle to side", 0.01, 5);
    add(&HardwareFile::height_m, "height_m", "Its highest point", 0.05, 5);
    add(&HardwareFile::wheel_track_m, "wheel_track_m", "Wheel to wheel", 0.05,
        5);
    add(&HardwareFile::max_forward_mps, "max_forward_mps", "Its speed", 0.05,
        3);
    add(&HardwareFile::laser_x_m, "laser_x_m", "The laser, ahead", -5, 5);
    add(&HardwareFile::laser_y_m, "laser_y_m", "... to the left", -5, 5);
    add(&HardwareFile::laser_z_m, "laser_z_m", "... and up", 0, 5);
    add(&HardwareFile::laser_yaw_rad, "laser_yaw_rad",
        "... and where it looks, from ahead counter-clockwise", -6.3, 6.3);
    add(&HardwareFile::rear_laser_x_m, "rear_laser_x_m",
        "The rear laser, ahead", -5, 5);
    add(&HardwareFile::rear_laser_y_m, "rear_laser_y_m", "... to the left", -5,
        5);
    add(&HardwareFile::rear_laser_z_m, "rear_laser_z_m", "... and up", 0, 5);
    add(&HardwareFile::rear_laser_yaw_rad, "rear_laser_yaw_rad",
        "... and where it looks, from ahead counter-clockwise", -6.3, 6.3);
    add(&HardwareFile::camera_x_m, "camera_x_m", "The camera, ahead", -5, 5);
    add(&HardwareFile::camera_y_m, "camera_y_m", "... to the left", -5, 5);
    add(&HardwareFile::camera_z_m, "camera_z_m", "... and up", 0, 5);
    add(&HardwareFile::camera_down_rad, "camera_down_rad",
        "How far below the horizon it looks", -1.5, 1.5);
    add(&HardwareFile::left_wheel_scale, "left_wheel_scale",
        "What the left wheel counts is multiplied by", 0.5, 2);
    add(&HardwareFile::right_wheel_scale, "right_wheel_scale",
        "... and the right one", 0.5, 2);
    add(&HardwareFile::laser_delay_s, "laser_delay_s",
        "Scans are stamped later than wheel readings by this", -0.5, 0.5);
    add(&HardwareFile::camera_delay_s, "camera_delay_s",
        "... and pictures of the camera", -0.5, 0.5);
    for (const auto& [name, value] : core::kNoiseKeys) {
      add(value, name, "How noisy odometry was measured to be", 0,
          core::kMostNoise);
    }
    return made;
  }();
  return *table;
}

}  // namespace

absl::Status HardwareConfig::Validate() const {
  if (laser.empty() || base.empty()) {
    return absl::InvalidArgumentError(
        "a robot needs the addresses of its laser and its base: "
        "/dev/ttyACM0, /dev/ttyUSB0@460800 or tcp:HOST:PORT");
  }
  if (camera != "none" && camera != "openni") {
    return absl::InvalidArgumentError(absl::StrCat(
        "'", camera, "' is no camera of a robot; there are none and openni"));
  }
  TL_RETURN_IF_ERROR(
      stream::ParseStreamAddress(laser, kLaserBaud, kLaserPort).status());
  if (!rear_laser.empty()) {
    TL_RETURN_IF_ERROR(
        stream::ParseStreamAddress(rear_laser, kLaserBaud, kLaserPort)
            .status());
    if (rear_laser == laser) {
      return absl::InvalidArgumentError(absl::StrCat(
          "laser and rear_laser are both at ", laser, "; they are two"));
    }
  }
  TL_RETURN_IF_ERROR(
      stream::ParseStreamAddress(base, segway::kSegwayBaud).status());
  TL_RETURN_IF_ERROR(correction.Validate());
  return robot.Validate();
}

absl::StatusOr<HardwareConfig> ReadHardwareConfig(const std::string& path) {
  const config::ConfigTable<HardwareFile>& table = HardwareTable();
  TL_ASSIGN_OR_RETURN(const config::EffectiveConfig effective,
                      config::ResolveConfig(table.settings(), {.file = path}));
  const HardwareFile file = table.Make(effective);
  HardwareConfig config{.laser = file.laser,
                        .base = file.base,
                        .rear_laser = file.rear_laser,
                        .camera = file.camera,
                        .robot = {},
                        .correction = {.left_scale = file.left_wheel_scale,
                                       .right_scale = file.right_wheel_scale,
                                       .laser_delay_s = file.laser_delay_s,
                                       .camera_delay_s = file.camera_delay_s}};
  const auto noise = core::NoiseOfFile(file);
  if (!noise.ok()) return base::Annotate(noise.status(), path);
  config.noise = *noise;
  TL_ASSIGN_OR_RETURN(config.contacts,
                      core::ContactEndOf(file.charging_contacts));
  config.robot.front_m = file.front_m;
  config.robot.rear_m = file.rear_m;
  config.robot.half_width_m = file.half_width_m;
  config.robot.height_m = file.height_m;
  config.robot.wheel_track_m = file.wheel_track_m;
  config.robot.max_forward_mps = file.max_forward_mps;
  config.robot.base_from_laser = {
      .rotation =
          geometry::Rotation3::FromAxisAngle({0, 0, file.laser_yaw_rad}),
      .translation = {file.laser_x_m, file.laser_y_m, file.laser_z_m}};
  config.robot.base_from_rear_laser = {
      .rotation =
          geometry::Rotation3::FromAxisAngle({0, 0, file.rear_laser_yaw_rad}),
      .translation = {file.rear_laser_x_m, file.rear_laser_y_m,
                      file.rear_laser_z_m}};
  config.robot.base_from_camera = core::RobotModel::UprightCamera(
      {file.camera_x_m, file.camera_y_m, file.camera_z_m},
      file.camera_down_rad);
  const absl::Status valid = config.Validate();
  if (!valid.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": ", valid.message()));
  }
  return config;
}

absl::StatusOr<std::unique_ptr<RobotHardware>> RobotHardware::Open(
    const HardwareConfig& config, const base::Clock& clock) {
  TL_RETURN_IF_ERROR(config.Validate());
  std::unique_ptr<RobotHardware> hardware(new RobotHardware());
  TL_ASSIGN_OR_RETURN(auto laser, stream::ParseStreamAddress(
                                      config.laser, kLaserBaud, kLaserPort));
  TL_ASSIGN_OR_RETURN(hardware->laser_,
                      hokuyo::HokuyoLaser::Start({}, std::move(laser), clock));
  if (!config.rear_laser.empty()) {
    TL_ASSIGN_OR_RETURN(
        auto rear,
        stream::ParseStreamAddress(config.rear_laser, kLaserBaud, kLaserPort));
    TL_ASSIGN_OR_RETURN(hardware->rear_laser_,
                        hokuyo::HokuyoLaser::Start({}, std::move(rear), clock));
  }
  TL_ASSIGN_OR_RETURN(
      auto base, stream::ParseStreamAddress(config.base, segway::kSegwayBaud));
  segway::SegwayBaseOptions base_options;
  base_options.protocol.wheel_track_m = config.robot.wheel_track_m;
  TL_ASSIGN_OR_RETURN(
      hardware->base_,
      segway::SegwayBase::Create(base_options, std::move(base), clock));
  if (config.camera == "openni") {
    TL_ASSIGN_OR_RETURN(hardware->camera_,
                        openni_camera::MakeOpenNiCamera(
                            {}, openni_camera::MakeOpenNi2(clock), clock));
  }
  return hardware;
}

}  // namespace treeline::hardware
