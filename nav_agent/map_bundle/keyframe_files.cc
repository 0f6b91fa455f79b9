#include "nav_agent/map_bundle/keyframe_files.h"

#include <cmath>
#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/camera/calibration_json.h"
#include "common/dataset/text_formats.h"
#include "common/image/decode.h"

namespace treeline::map_bundle {
namespace {

constexpr double kMillimetre = 0.001;

absl::StatusOr<std::string> InMillimetres(absl::string_view depth,
                                          double depth_unit_m) {
  TL_ASSIGN_OR_RETURN(image::DepthImage image,
                      image::DecodeDepthPng(depth, depth_unit_m));
  for (uint16_t& value : image.values) {
    const double mm = image::IsMeasured(value)
                          ? std::round(value * depth_unit_m / kMillimetre)
                          : 0;
    value = mm < 65535 ? static_cast<uint16_t>(mm) : uint16_t{0};
  }
  image.unit_m = kMillimetre;
  return image::EncodeDepthPng(image);
}

}  // namespace

absl::StatusOr<KeyframeWriter> KeyframeWriter::Create(
    const std::string& folder, const camera::RgbdCalibration& calibration) {
  const std::string sequence = folder + "/seq-01";
  std::error_code error;
  if (std::filesystem::exists(sequence, error)) {
    return absl::AlreadyExistsError(
        absl::StrCat(sequence, ": there is a sequence already"));
  }
  std::filesystem::create_directories(sequence, error);
  if (error) {
    return absl::UnavailableError(
        absl::StrCat("making ", sequence, ": ", error.message()));
  }
  TL_RETURN_IF_ERROR(base::WriteFileAtomically(
      folder + "/calibration.json", camera::CalibrationToJson(calibration)));
  return KeyframeWriter(sequence, calibration);
}

absl::Status KeyframeWriter::Write(absl::string_view color,
                                   absl::string_view depth, double depth_unit_m,
                                   const geometry::Rigid3& map_from_camera) {
  if (!geometry::IsFinite(map_from_camera)) {
    return absl::InvalidArgumentError("the camera's pose is not finite");
  }
  const auto format = image::SniffFormat(color);
  if (format == image::ImageFormat::kUnknown) {
    return absl::InvalidArgumentError("the colour picture is no JPEG or PNG");
  }
  const std::string stem = absl::StrFormat("%s/frame-%06d", sequence_, count_);
  if (depth_unit_m == kMillimetre) {
    TL_RETURN_IF_ERROR(base::WriteNewFile(stem + ".depth.png", depth));
  } else {
    TL_ASSIGN_OR_RETURN(const std::string converted,
                        InMillimetres(depth, depth_unit_m));
    TL_RETURN_IF_ERROR(base::WriteNewFile(stem + ".depth.png", converted));
  }
  TL_RETURN_IF_ERROR(base::WriteNewFile(
      stem +
          (format == image::ImageFormat::kJpeg ? ".color.jpg" : ".color.png"),
      color));
  TL_RETURN_IF_ERROR(base::WriteNewFile(
      stem + ".pose.txt", dataset::FormatPoseMatrix(camera::PoseOfSensor(
                              map_from_camera, calibration_.pose_sensor,
                              camera::RgbdSensor::kDepth, calibration_))));
  ++count_;
  return absl::OkStatus();
}

}  // namespace treeline::map_bundle
