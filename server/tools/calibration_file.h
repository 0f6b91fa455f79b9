// A calibration from a file.
#ifndef SERVER_TOOLS_CALIBRATION_FILE_H_
#define SERVER_TOOLS_CALIBRATION_FILE_H_

#include <string>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"

namespace treeline::tools {

// What `treeline calibrate` wrote, or lies beside the keyframes of a map
// bundle. Errors of base::ReadFile; INVALID_ARGUMENT, naming file and field.
absl::StatusOr<camera::RgbdCalibration> ReadCalibrationFile(
    const std::string& path);

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_CALIBRATION_FILE_H_
