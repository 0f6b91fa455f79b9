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

namespace treeline {
namespace {

constexpr double kMillimetre = 0.001;

absl::StatusOr<std::string> InMillimetres(absl::string_view depth,
                                          double depth_unit_m) {
  TL_ASSIGN_OR_RETURN(DepthImage image, DecodeDepthPng(depth, depth_unit_m));
  for (uint16_t& value : image.values) {
    const double mm =
        IsMeasured(value) ? std::round(value * depth_unit_m / kMillimetre) : 0;
    value = mm < 65535 ? static_cast<uint16_t>(mm) : uint16_t{0};
  }
  image.unit_m = kMillimetre;
  return EncodeDepthPng(image);
}

}  // namespace

absl::StatusOr<KeyframeWriter> KeyframeWriter::Create(
    const std::string& folder, const RgbdCalibration& calibration) {
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
  TL_RETURN_IF_ERROR(WriteFileAtomically(folder + "/calibration.json",
                                         CalibrationToJson(calibration)));
  return KeyframeWriter(sequence, calibration);
}

absl::Status KeyframeWriter::Write(absl::string_view color,
                                   absl::string_view depth, double depth_unit_m,
                                   const Rigid3& map_from_camera) {
  if (!IsFinite(map_from_camera)) {
    return absl::InvalidArgumentError("the camera's pose is not finite");
  }
  const auto format = SniffFormat(color);
  if (format == ImageFormat::kUnknown) {
    return absl::InvalidArgumentError("the colour picture is no JPEG or PNG");
  }
  const std::string stem = absl::StrFormat("%s/frame-%06d", sequence_, count_);
  if (depth_unit_m == kMillimetre) {
    TL_RETURN_IF_ERROR(WriteNewFile(stem + ".depth.png", depth));
  } else {
    TL_ASSIGN_OR_RETURN(const std::string converted,
                        InMillimetres(depth, depth_unit_m));
    TL_RETURN_IF_ERROR(WriteNewFile(stem + ".depth.png", converted));
  }
  TL_RETURN_IF_ERROR(WriteNewFile(
      stem + (format == ImageFormat::kJpeg ? ".color.jpg" : ".color.png"),
      color));
  TL_RETURN_IF_ERROR(WriteNewFile(
      stem + ".pose.txt",
      FormatPoseMatrix(PoseOfSensor(map_from_camera, calibration_.pose_sensor,
                                    RgbdSensor::kDepth, calibration_))));
  ++count_;
  return absl::OkStatus();
}

}  // namespace treeline
