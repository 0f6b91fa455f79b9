// An RgbdCalibration as JSON: the file that `treeline calibrate` writes, and
// that lies beside the frames of a map bundle.
#ifndef COMMON_CAMERA_CALIBRATION_JSON_H_
#define COMMON_CAMERA_CALIBRATION_JSON_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/rgbd_calibration.h"

namespace treeline::camera {

// Cameras as Camera::ToString has them, quaternions and metres, and the pose's
// sensor; numbers are exact.
std::string CalibrationToJson(const RgbdCalibration& calibration);
// INVALID_ARGUMENT, naming the field, for anything malformed.
absl::StatusOr<RgbdCalibration> CalibrationFromJson(absl::string_view json);

}  // namespace treeline::camera

#endif  // COMMON_CAMERA_CALIBRATION_JSON_H_
