#include "common/wire/camera.h"

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/wire/geometry.h"

namespace treeline::wire {
namespace {

// Longer names are not repeated in messages.
constexpr size_t kLongestModelName = 32;

}  // namespace

v1::Camera ToProto(const camera::Camera& camera) {
  v1::Camera proto;
  const absl::string_view model = camera::CameraModelName(camera.model());
  proto.set_model(model.data(), model.size());
  proto.set_width_px(camera.width());
  proto.set_height_px(camera.height());
  proto.mutable_parameters()->Add(
      camera.parameters().begin(),
      camera.parameters().begin() +
          camera::CameraParameterCount(camera.model()));
  return proto;
}

absl::StatusOr<camera::Camera> FromProto(const v1::Camera& proto,
                                         absl::string_view field) {
  if (proto.model().size() > kLongestModelName) {
    return FieldError(field, "the name of the model is too long");
  }
  const absl::StatusOr<camera::CameraModel> model =
      camera::ParseCameraModel(absl::CEscape(proto.model()));
  if (!model.ok()) return base::Annotate(model.status(), field);
  const absl::StatusOr<camera::Camera> camera = camera::Camera::Create(
      *model, proto.width_px(), proto.height_px(), proto.parameters().data(),
      proto.parameters_size());
  if (!camera.ok()) return base::Annotate(camera.status(), field);
  return camera;
}

v1::RgbdSensor ToProto(camera::RgbdSensor sensor) {
  return sensor == camera::RgbdSensor::kColor ? v1::RGBD_SENSOR_COLOR
                                              : v1::RGBD_SENSOR_DEPTH;
}

absl::StatusOr<camera::RgbdSensor> FromProto(v1::RgbdSensor proto,
                                             absl::string_view field) {
  switch (proto) {
    case v1::RGBD_SENSOR_COLOR:
      return camera::RgbdSensor::kColor;
    case v1::RGBD_SENSOR_DEPTH:
      return camera::RgbdSensor::kDepth;
    default:
      return FieldError(field, "neither the colour nor the depth camera");
  }
}

v1::RgbdCalibration ToProto(const camera::RgbdCalibration& calibration) {
  v1::RgbdCalibration proto;
  *proto.mutable_color() = ToProto(calibration.color);
  *proto.mutable_depth() = ToProto(calibration.depth);
  *proto.mutable_color_from_depth() = ToProto(calibration.color_from_depth);
  proto.set_depth_scale(calibration.depth_scale);
  proto.set_pose_sensor(ToProto(calibration.pose_sensor));
  return proto;
}

absl::StatusOr<camera::RgbdCalibration> FromProto(
    const v1::RgbdCalibration& proto, absl::string_view field) {
  camera::RgbdCalibration calibration;
  TL_ASSIGN_OR_RETURN(calibration.color,
                      FromProto(proto.color(), absl::StrCat(field, ".color")));
  TL_ASSIGN_OR_RETURN(calibration.depth,
                      FromProto(proto.depth(), absl::StrCat(field, ".depth")));
  TL_ASSIGN_OR_RETURN(calibration.color_from_depth,
                      FromProto(proto.color_from_depth(),
                                absl::StrCat(field, ".color_from_depth")));
  TL_RETURN_IF_ERROR(CheckDepthScale(proto.depth_scale(),
                                     absl::StrCat(field, ".depth_scale")));
  calibration.depth_scale = proto.depth_scale();
  TL_ASSIGN_OR_RETURN(
      calibration.pose_sensor,
      FromProto(proto.pose_sensor(), absl::StrCat(field, ".pose_sensor")));
  return calibration;
}

absl::Status CheckDepthScale(double depth_scale, absl::string_view field) {
  // Written so that NaN fails.
  if (depth_scale >= kMinDepthScale && depth_scale <= kMaxDepthScale) {
    return absl::OkStatus();
  }
  return FieldError(field, absl::StrCat(depth_scale, " is outside ",
                                        kMinDepthScale, "..", kMaxDepthScale));
}

}  // namespace treeline::wire
