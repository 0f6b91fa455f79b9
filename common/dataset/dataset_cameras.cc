#include "common/dataset/dataset_cameras.h"

#include <algorithm>
#include <array>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/camera/calibration_json.h"
#include "common/dataset/picture_files.h"
#include "common/image/decode.h"

namespace treeline::dataset {
namespace {

// The camera from `option`, or the format's default, which holds for one image
// size only.
absl::StatusOr<camera::Camera> ChooseCamera(absl::string_view name,
                                            const std::string& option,
                                            const std::string& default_camera,
                                            const DefaultCameras& defaults,
                                            image::ImageSize size,
                                            const std::string& uri) {
  if (option.empty() &&
      size != image::ImageSize{defaults.width, defaults.height}) {
    return absl::InvalidArgumentError(absl::StrCat(
        uri, ": images are ", size.width, " x ", size.height,
        " pixels, but the default ", name, " camera is for ", defaults.width,
        " x ", defaults.height, "; give the ", name, " camera"));
  }
  return camera::Camera::Parse(option.empty() ? default_camera : option,
                               size.width, size.height);
}

absl::StatusOr<camera::Camera> WithFocalLength(const camera::Camera& camera,
                                               double focal_px) {
  std::array<double, camera::Camera::kMaxParameters> parameters =
      camera.parameters();
  parameters[0] = focal_px;
  parameters[1] = focal_px;  // The defaults all have fx and fy.
  return camera::Camera::Create(camera.model(), camera.width(), camera.height(),
                                parameters.data(),
                                camera::CameraParameterCount(camera.model()));
}

// What the recording says, with what the options replace.
absl::StatusOr<camera::RgbdCalibration> RecordedCalibration(
    const DatasetOptions& options, camera::RgbdCalibration calibration) {
  if (!options.pose_file.empty()) {
    calibration.pose_sensor = camera::RgbdSensor::kColor;
  }
  for (auto [option, camera] :
       {std::pair(&options.color_camera, &calibration.color),
        std::pair(&options.depth_camera, &calibration.depth)}) {
    if (option->empty()) continue;
    TL_ASSIGN_OR_RETURN(*camera, camera::Camera::Parse(*option, camera->width(),
                                                       camera->height()));
  }
  return calibration;
}

absl::StatusOr<camera::Camera> DepthCamera(const DatasetOptions& options,
                                           const DatasetIndex& index,
                                           const DefaultCameras& defaults,
                                           const camera::Camera& color) {
  if (DepthIsRegistered(index)) {
    if (options.depth_camera.empty()) return color;
    return absl::InvalidArgumentError(absl::StrCat(
        options.uri,
        ": depth is registered to colour in this format and "
        "takes the colour camera; a depth camera cannot be given"));
  }
  const auto with_depth = std::ranges::find_if(
      index.frames,
      [](const DatasetFrame& frame) { return !frame.depth_path.empty(); });
  image::ImageSize size{defaults.width, defaults.height};
  if (with_depth != index.frames.end()) {
    TL_ASSIGN_OR_RETURN(size, ReadPictureSize(with_depth->depth_path));
  }
  return ChooseCamera("depth", options.depth_camera, defaults.depth, defaults,
                      size, options.uri);
}

absl::StatusOr<camera::RgbdCalibration> DefaultCalibration(
    const DatasetOptions& options, const DatasetIndex& index,
    const DefaultCameras& defaults, std::optional<double> focal_length_px) {
  camera::RgbdCalibration calibration;
  TL_ASSIGN_OR_RETURN(const image::ImageSize size,
                      ReadPictureSize(index.frames[0].color_path));
  TL_ASSIGN_OR_RETURN(
      calibration.color,
      ChooseCamera("colour", options.color_camera, defaults.color, defaults,
                   size, options.uri));
  if (options.color_camera.empty() && focal_length_px.has_value()) {
    TL_ASSIGN_OR_RETURN(calibration.color,
                        WithFocalLength(calibration.color, *focal_length_px));
  }
  calibration.pose_sensor = options.pose_file.empty()
                                ? defaults.pose_sensor
                                : camera::RgbdSensor::kColor;
  TL_ASSIGN_OR_RETURN(calibration.depth,
                      DepthCamera(options, index, defaults, calibration.color));
  return calibration;
}

}  // namespace

absl::Status ReadCamerasFile(const std::string& folder, DatasetIndex& index) {
  const std::string path = folder + "/cameras.json";
  if (!base::IsFile(path)) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const std::string json, base::ReadFile(path, 1u << 20));
  const absl::StatusOr<camera::RgbdCalibration> cameras =
      camera::CalibrationFromJson(json);
  if (!cameras.ok()) return base::Annotate(cameras.status(), path);
  index.cameras = *cameras;
  return absl::OkStatus();
}

bool DepthIsRegistered(const DatasetIndex& index) {
  const auto* defaults = std::get_if<DefaultCameras>(&index.cameras);
  return defaults != nullptr && defaults->depth.empty();
}

absl::StatusOr<camera::RgbdCalibration> ChooseCalibration(
    const DatasetOptions& options, const DatasetIndex& index,
    std::optional<double> focal_length_px) {
  const auto* recorded = std::get_if<camera::RgbdCalibration>(&index.cameras);
  // The readers of structure from motion have put the option's camera there.
  if (recorded != nullptr && index.structure != nullptr) return *recorded;
  if (recorded != nullptr) return RecordedCalibration(options, *recorded);
  return DefaultCalibration(
      options, index, std::get<DefaultCameras>(index.cameras), focal_length_px);
}

}  // namespace treeline::dataset
