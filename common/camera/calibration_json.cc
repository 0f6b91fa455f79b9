#include "common/camera/calibration_json.h"

#include <exception>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::camera {
namespace {

using Json = nlohmann::ordered_json;

Json CameraToJson(const Camera& camera) {
  return {{"width", camera.width()},
          {"height", camera.height()},
          {"model", camera.ToString()}};
}

Json ToJson(const RgbdCalibration& calibration) {
  const geometry::Rotation3& q = calibration.color_from_depth.rotation;
  const geometry::Vec3& t = calibration.color_from_depth.translation;
  return {{"color", CameraToJson(calibration.color)},
          {"depth", CameraToJson(calibration.depth)},
          {"color_from_depth",
           {{"qw", q.w},
            {"qx", q.x},
            {"qy", q.y},
            {"qz", q.z},
            {"tx_m", t.x},
            {"ty_m", t.y},
            {"tz_m", t.z}}},
          {"depth_scale", calibration.depth_scale},
          {"pose_sensor",
           calibration.pose_sensor == RgbdSensor::kColor ? "color" : "depth"}};
}

absl::StatusOr<Camera> CameraFromJson(const Json& json) {
  return Camera::Parse(json.at("model").get<std::string>(),
                       json.at("width").get<int>(),
                       json.at("height").get<int>());
}

absl::StatusOr<RgbdCalibration> FromJson(const Json& json) {
  RgbdCalibration calibration;
  TL_ASSIGN_OR_RETURN(calibration.color, CameraFromJson(json.at("color")));
  TL_ASSIGN_OR_RETURN(calibration.depth, CameraFromJson(json.at("depth")));
  const Json& pose = json.at("color_from_depth");
  TL_ASSIGN_OR_RETURN(
      calibration.color_from_depth,
      geometry::RigidFromQuaternion(
          pose.at("qw").get<double>(), pose.at("qx").get<double>(),
          pose.at("qy").get<double>(), pose.at("qz").get<double>(),
          {pose.at("tx_m").get<double>(), pose.at("ty_m").get<double>(),
           pose.at("tz_m").get<double>()}));
  calibration.depth_scale = json.at("depth_scale").get<double>();
  if (!(calibration.depth_scale >= 0.5 && calibration.depth_scale <= 2)) {
    return absl::InvalidArgumentError(
        absl::StrCat("depth_scale is ", calibration.depth_scale,
                     "; it must be between 0.5 and 2"));
  }
  const std::string sensor = json.at("pose_sensor").get<std::string>();
  if (sensor != "color" && sensor != "depth") {
    return absl::InvalidArgumentError(absl::StrCat(
        "pose_sensor is \"", sensor, "\"; it must be \"color\" or \"depth\""));
  }
  calibration.pose_sensor =
      sensor == "color" ? RgbdSensor::kColor : RgbdSensor::kDepth;
  return calibration;
}

}  // namespace

std::string CalibrationToJson(const RgbdCalibration& calibration) {
  return ToJson(calibration).dump(2) + "\n";
}

absl::StatusOr<RgbdCalibration> CalibrationFromJson(absl::string_view json) {
  try {
    return FromJson(Json::parse(json.begin(), json.end()));
  } catch (const std::exception& error) {
    return absl::InvalidArgumentError(error.what());
  }
}

}  // namespace treeline::camera
